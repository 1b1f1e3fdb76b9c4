// SPDX-License-Identifier: Apache-2.0
// A scene's points for io::write_ply().
#pragma once

#include <vector>

#include "covis/exchange/scene.h"
#include "covis/io/outputs.h"

namespace covis::exchange {

// `R`: the map's world in that of the cloud.
inline std::vector<io::CloudPoint> cloud_of(const Scene& scene,
                                            const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity()) {
  std::vector<io::CloudPoint> cloud;
  cloud.reserve(scene.points.size());
  for (const ScenePoint& point : scene.points) cloud.push_back({R * point.position, point.colour, R * point.normal});
  return cloud;
}

}  // namespace covis::exchange
