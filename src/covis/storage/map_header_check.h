// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "covis/storage/map_file.h"

namespace covis::storage {

// Returns what is wrong with a camera's values; empty: nothing.
std::string problem_of(const Camera& camera);

// Returns what is wrong with a header's values; empty: nothing. The names of enums are checked too.
std::string problem_of(const MapHeader& header);

}  // namespace covis::storage
