// SPDX-License-Identifier: Apache-2.0
// Reading of YAML with errors that name file and line. For .cpp files of this module only.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>

#include "covis/core/error.h"

namespace covis::io {

Result<YAML::Node> load_yaml(const std::filesystem::path& file);
// Returns "file:line" of a node.
std::string yaml_place(const std::filesystem::path& file, const YAML::Node& node);

}  // namespace covis::io
