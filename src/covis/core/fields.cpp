// SPDX-License-Identifier: Apache-2.0
#include "covis/core/fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

namespace covis {
namespace {

// Levenshtein distance.
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

template <class T>
bool parse_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

std::string number(double value) {
  std::string text(32, '\0');
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  text.resize(error == std::errc() ? static_cast<size_t>(end - text.data()) : 0);
  return text;
}

// As people write it: 1000000, not 1e+06.
std::string bound(double value) {
  const bool is_whole = value == std::floor(value) && std::abs(value) < 1e15;
  return is_whole ? std::to_string(static_cast<int64_t>(value)) : number(value);
}

tl::unexpected<Error> wrong(const Field& field, std::string_view text, std::string_view wanted) {
  return fail(field.name + ": '" + std::string(text) + "' is not right; it must be " + std::string(wanted) + " (" +
              field.doc + ")");
}

bool is_allowed(const Field& field, double value) {
  return (value >= field.min && value <= field.max) || value == field.also;
}

std::string range(const Field& field, std::string_view kind) { return std::string(kind) + " " + field_range(field); }

}  // namespace

std::string field_range(const Field& field) {
  const bool low = field.min > std::numeric_limits<double>::lowest(),
             high = field.max < std::numeric_limits<double>::max();
  std::string text;
  if (low) text = "from " + bound(field.min);
  if (high) text += (low ? " to " : "up to ") + bound(field.max);
  if (field.also) text += ", or " + bound(*field.also);
  return text;
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  std::string best;
  size_t best_distance = std::string::npos;
  for (const std::string& candidate : names) {
    const size_t distance = edit_distance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

Result<void> set_field(const Fields& fields, std::string_view name, std::string_view text) {
  const auto field = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
  if (field == fields.end()) {
    const auto renamed = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.former == name; });
    if (renamed != fields.end() && !name.empty())
      return fail("the setting '" + std::string(name) + "' is called '" + renamed->name + "' now");
    std::vector<std::string> names;
    for (const Field& f : fields) names.push_back(f.name);
    return fail("unknown setting '" + std::string(name) + "'; the nearest known one is '" + nearest_name(name, names) +
                "'");
  }
  if (auto* const* target = std::get_if<bool*>(&field->value)) {
    if (text != "true" && text != "false") return wrong(*field, text, "true or false");
    **target = text == "true";
  } else if (auto* const* integer = std::get_if<int*>(&field->value)) {
    int value = 0;
    if (!parse_number(text, value) || !is_allowed(*field, value)) {
      return wrong(*field, text, range(*field, "a whole number"));
    }
    **integer = value;
  } else if (auto* const* real = std::get_if<double*>(&field->value)) {
    double value = 0;
    if (!parse_number(text, value) || !std::isfinite(value) || !is_allowed(*field, value)) {
      return wrong(*field, text, range(*field, "a number"));
    }
    **real = value;
  } else {
    *std::get<std::string*>(field->value) = text;
  }
  return {};
}

std::string field_text(const Field& field) {
  if (auto* const* boolean = std::get_if<bool*>(&field.value)) return **boolean ? "true" : "false";
  if (auto* const* integer = std::get_if<int*>(&field.value)) return std::to_string(**integer);
  if (auto* const* real = std::get_if<double*>(&field.value)) return number(**real);
  return *std::get<std::string*>(field.value);
}

}  // namespace covis
