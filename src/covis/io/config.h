// SPDX-License-Identifier: Apache-2.0
// Settings files: YAML that is read, checked against the list of fields (core/fields.h), and written.
#pragma once

#include <filesystem>
#include <string>

#include "covis/core/error.h"
#include "covis/core/fields.h"

namespace covis::io {

// Sets the fields named in a YAML file; a dotted name is a nested map ("orb: {features: 2000}" or "orb.features:
// 2000"). Errors name the file, the line, the key, and the accepted values.
Result<void> load_settings(const std::filesystem::path& file, const Fields& fields);

// Returns all fields with their current values as YAML, each with its meaning and range as a comment. load_settings()
// can read it.
std::string dump_settings(const Fields& fields);

}  // namespace covis::io
