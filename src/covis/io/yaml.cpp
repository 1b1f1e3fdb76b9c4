// SPDX-License-Identifier: Apache-2.0
#include "covis/io/yaml.h"

#include "covis/io/files.h"

namespace covis::io {

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

}  // namespace covis::io
