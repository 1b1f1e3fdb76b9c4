// SPDX-License-Identifier: Apache-2.0
#include "covis/io/config.h"

#include <cstdio>
#include <set>

#include "covis/io/yaml.h"

namespace covis::io {
namespace {

Result<void> load_map(const std::filesystem::path& file, const YAML::Node& node, const std::string& prefix,
                      const Fields& fields, std::set<std::string>& seen) {
  for (const auto& entry : node) {
    const std::string name = prefix + entry.first.Scalar();
    if (entry.second.IsMap()) {
      if (auto loaded = load_map(file, entry.second, name + ".", fields, seen); !loaded) return loaded;
      continue;
    }
    const std::string where = yaml_place(file, entry.first);
    if (!seen.insert(name).second) return fail(where + ": '" + name + "' is given twice");
    if (!entry.second.IsScalar())
      return fail(where + ": '" + name + "' must be a single value" +
                  std::string(entry.second.IsNull() ? "; there is none" : ""));
    if (auto set = set_field(fields, name, entry.second.Scalar()); !set)
      return fail(where + ": " + set.error().message);
  }
  return {};
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if ((c >= 0 && c < ' ') || c == '\x7f') {  // YAML does not take it as it is
      char escaped[5];
      std::snprintf(escaped, sizeof escaped, "\\x%02x", static_cast<unsigned>(c));
      result += escaped;
      continue;
    }
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

}  // namespace

Result<void> load_settings(const std::filesystem::path& file, const Fields& fields) {
  const auto root = load_only_yaml(file);
  if (!root) return tl::unexpected(root.error());
  if (root->IsNull()) return {};
  if (!root->IsMap()) return fail(file.string() + ": it must be a map of settings, NAME: VALUE");
  std::set<std::string> seen;
  return load_map(file, *root, "", fields, seen);
}

std::string dump_settings(const Fields& fields) {
  std::string text, section;
  for (const Field& field : fields) {
    const size_t dot = field.name.find('.');
    const std::string head = dot == std::string::npos ? "" : field.name.substr(0, dot);
    if (head != section) {
      text += head + ":\n";
      section = head;
    }
    text += head.empty() ? "" : "  ";
    text += field.name.substr(dot == std::string::npos ? 0 : dot + 1) + ": ";
    const bool is_text = std::holds_alternative<std::string*>(field.value);
    text += (is_text ? quoted(field_text(field)) : field_text(field)) + "  # " + field.doc;
    if (const std::string range = field_range(field); !range.empty()) text += "; " + range;
    text += "\n";
  }
  return text;
}

}  // namespace covis::io
