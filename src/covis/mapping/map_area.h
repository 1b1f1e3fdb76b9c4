// SPDX-License-Identifier: Apache-2.0
// The part of a saved map that lies in an area, for a robot that carries no more.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "covis/core/error.h"
#include "covis/map/map.h"

namespace covis {

// Leaves the key frames whose centres (world, metres) are inside, and the points that enough of these see
// (Map::erase_key_frame). A submap stays one, in its world, also where the area cuts it into pieces; one that has no
// key frame there is left out. Fails when there is none at all.
Result<Map> part_of(const Map& map, const std::function<bool(const Eigen::Vector3d&)>& inside);

}  // namespace covis
