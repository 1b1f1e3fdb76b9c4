// SPDX-License-Identifier: Apache-2.0
// A table with books on it, a chair on either side and a rug below, for the middle of a room.
#pragma once

#include <vector>

#include "synth/things/interior.h"

namespace covis::synth {

// Builds the group around the point `at` of the floor; it takes about 2 x 2 m.
void add_table_group(Scene& scene, const Vector2d& at, std::vector<Floor>& floors);

}  // namespace covis::synth
