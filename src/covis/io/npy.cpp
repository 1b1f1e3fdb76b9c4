// SPDX-License-Identifier: Apache-2.0
#include "covis/io/npy.h"

#include <charconv>
#include <cstring>
#include <utility>

#include "covis/io/files.h"

namespace covis::io {
namespace {

constexpr std::string_view kNpyMagic = "\x93NUMPY";
constexpr size_t kLargestNpySide = 32767;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\n')) text.remove_suffix(1);
  return text;
}

// Splits the file into its header, a dictionary in Python's notation, and what follows it; empty: it is cut short or
// none.
std::pair<std::string_view, std::string_view> split_header(std::string_view bytes) {
  const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<unsigned char>(bytes[i])); };
  if (!bytes.starts_with(kNpyMagic) || bytes.size() < 12) return {};
  const bool first = byte(6) == 1, second = byte(6) == 2;
  if (!(first || second) || byte(7) != 0) return {};
  const size_t begin = first ? 10 : 12;
  const size_t size = byte(8) + (byte(9) << 8) + (second ? (byte(10) << 16) + (byte(11) << 24) : 0);
  if (size > bytes.size() - begin) return {};
  return {trimmed(bytes.substr(begin, size)), bytes.substr(begin + size)};
}

// The value of a key as it is written; empty: there is none.
std::string_view header_value(std::string_view header, std::string_view key) {
  const size_t found = header.find("'" + std::string(key) + "':");
  if (found == std::string_view::npos) return {};
  const size_t begin = found + key.size() + 3;
  int depth = 0;  // number of open brackets
  for (size_t end = begin; end < header.size(); ++end) {
    const char c = header[end];
    if (depth == 0 && (c == ',' || c == '}')) return trimmed(header.substr(begin, end - begin));
    depth += (c == '(' || c == '[') - (c == ')' || c == ']');
  }
  return {};
}

// Parses "(480, 640)": rows and columns, or zeros.
std::pair<size_t, size_t> parse_shape(std::string_view shape) {
  if (!shape.starts_with('(') || !shape.ends_with(')')) return {};
  const auto parts = split(shape.substr(1, shape.size() - 2));
  size_t sides[2] = {};
  if (parts.size() != 2) return {};
  for (size_t i = 0; i < 2; ++i) {
    const auto [end, error] = std::from_chars(parts[i].data(), parts[i].data() + parts[i].size(), sides[i]);
    if (error != std::errc() || end != parts[i].data() + parts[i].size()) return {};
  }
  return {sides[0], sides[1]};
}

std::string shown(std::string_view value) { return value.empty() ? "missing" : std::string(value); }

}  // namespace

Result<void> parse_npy(const std::string& name, std::string_view bytes, ImageF& array) {
  const auto [header, data] = split_header(bytes);
  if (!header.starts_with('{') || !header.ends_with('}'))
    return fail(name + ": it is not a NumPy file of version 1.0 or 2.0, or its header is cut short");
  if (const auto type = header_value(header, "descr"); type != "'<f4'")
    return fail(name + ": descr is " + shown(type) + "; it must be '<f4' (32-bit float)");
  if (const auto order = header_value(header, "fortran_order"); order != "False")
    return fail(name + ": fortran_order is " + shown(order) + "; it must be False");
  const std::string_view shape = header_value(header, "shape");
  const auto [rows, columns] = parse_shape(shape);
  if (rows < 1 || columns < 1 || rows > kLargestNpySide || columns > kLargestNpySide) {
    return fail(name + ": shape is " + shown(shape) + "; it must be (rows, columns) of at most " +
                std::to_string(kLargestNpySide) + " each");
  }
  const size_t row_bytes = columns * sizeof(float), wanted = rows * row_bytes;
  if (data.size() != wanted) {
    return fail(name + ": its shape " + std::string(shape) + " wants " + std::to_string(wanted) +
                " bytes of data, and there are " + std::to_string(data.size()) +
                (data.size() < wanted ? ": the file is cut short" : ""));
  }
  array.resize(static_cast<int>(columns), static_cast<int>(rows));
  for (size_t y = 0; y < rows; ++y) std::memcpy(array.row(static_cast<int>(y)), data.data() + y * row_bytes, row_bytes);
  return {};
}

}  // namespace covis::io
