// SPDX-License-Identifier: Apache-2.0
// Reading of YAML with errors that name file and line. For .cpp files of this module only.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"

namespace covis::io {

// Reads the first document of a file. What it holds is finite: a node that contains itself by an alias is refused.
Result<YAML::Node> load_yaml(const std::filesystem::path& file);
// The same, of a file that must have no other document, so that nothing of it is passed over.
Result<YAML::Node> load_only_yaml(const std::filesystem::path& file);
// Returns "file:line" of a node.
std::string yaml_place(const std::filesystem::path& file, const YAML::Node& node);
// Reads the finite numbers of a key: a list, lists in a list (the rows of a matrix), or the list `data` of a matrix as
// OpenCV and ROS write one. Fails when there are fewer than `least`.
Result<std::vector<double>> yaml_numbers(const std::filesystem::path& file, const YAML::Node& parent, const char* key,
                                         size_t least);
// Reads one finite number.
Result<double> yaml_number(const std::filesystem::path& file, const YAML::Node& parent, const char* key);
// Returns the text of a key, or `otherwise` where there is none.
std::string yaml_text(const YAML::Node& parent, const char* key, const std::string& otherwise);

}  // namespace covis::io
