// SPDX-License-Identifier: Apache-2.0
#include "covis/io/yaml.h"

#include "covis/io/files.h"

namespace covis::io {
namespace {

// Appends the numbers of a list and of the lists in it.
Result<void> append_numbers(const std::filesystem::path& file, const YAML::Node& list, const char* key,
                            std::vector<double>& values) {
  for (const auto& item : list) {
    if (item.IsSequence()) {
      if (auto appended = append_numbers(file, item, key, values); !appended) return appended;
      continue;
    }
    const std::string text = item.IsScalar() ? item.Scalar() : "a map";
    const auto value = parse_double(text);
    if (!value) return fail(yaml_place(file, item) + ": " + key + ": '" + text + "' is not a finite number");
    values.push_back(*value);
  }
  return {};
}

}  // namespace

Result<YAML::Node> load_yaml(const std::filesystem::path& file) {
  auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  // OpenCV and EuRoC write "%YAML:1.0", which is not a valid YAML directive.
  if (text->starts_with("%YAML:")) text->replace(0, 1, "#");
  try {
    return YAML::Load(*text);
  } catch (const YAML::Exception& error) {
    return fail(file.string() + ":" + std::to_string(error.mark.line + 1) + ": not YAML: " + error.msg);
  }
}

std::string yaml_place(const std::filesystem::path& file, const YAML::Node& node) {
  return file.string() + ":" + std::to_string(node.Mark().line + 1);
}

Result<std::vector<double>> yaml_numbers(const std::filesystem::path& file, const YAML::Node& parent, const char* key,
                                         size_t least) {
  YAML::Node node;
  if (parent.IsMap() && parent[key]) node = parent[key];
  if (node.IsMap() && node["data"]) node.reset(node["data"]);
  if (!node.IsSequence()) return fail(file.string() + ": '" + key + "' is missing, a list of numbers is expected");
  std::vector<double> values;
  if (auto appended = append_numbers(file, node, key, values); !appended) return tl::unexpected(appended.error());
  if (values.size() < least)
    return fail(yaml_place(file, node) + ": " + key + " needs " + std::to_string(least) + " numbers");
  return values;
}

Result<double> yaml_number(const std::filesystem::path& file, const YAML::Node& parent, const char* key) {
  const std::string text = yaml_text(parent, key, "");
  if (text.empty()) return fail(file.string() + ": '" + key + "' is missing, a number is expected");
  const auto value = parse_double(text);
  if (!value) return fail(yaml_place(file, parent[key]) + ": " + key + ": '" + text + "' is not a finite number");
  return *value;
}

std::string yaml_text(const YAML::Node& parent, const char* key, const std::string& otherwise) {
  if (!parent.IsMap() || !parent[key] || !parent[key].IsScalar()) return otherwise;
  return parent[key].Scalar();
}

}  // namespace covis::io
