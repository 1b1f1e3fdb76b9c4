// SPDX-License-Identifier: Apache-2.0
// A table with books on it, a chair at either side and a rug below: what stands in the middle of a room.
#pragma once

#include <vector>

#include "synth/things/interior.h"

namespace covis::synth {

// Takes about 2 x 2 m around the point `at` of the floor.
void add_table_group(Scene& scene, const Vector2d& at, std::vector<Floor>& floors);

}  // namespace covis::synth
