// SPDX-License-Identifier: Apache-2.0
// Makes points of features that a new key frame and its neighbours have in common, by triangulation or depth.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI-C; Mur-Artal and Tardós, "ORB-SLAM2", T-RO
// 2017, III-C.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/map/key_frame_view.h"
#include "covis/map/shared_map.h"
#include "covis/mapping/mapper_options.h"
#include "covis/mapping/recent_points.h"

namespace covis {

struct TriangulatedPoint {
  Eigen::Vector3d position_w;
  KeyFrameId neighbour;
  uint32_t feature = 0, neighbour_feature = 0;  // features of the new key frame and of the neighbour
};

// Points of features that no point has yet, with the first neighbour that shows them. Neighbours too near the new key
// frame are passed over.
std::vector<TriangulatedPoint> triangulate_points(const Pinhole& camera, Sensor sensor, const KeyFrameView& current,
                                                  const std::vector<KeyFrameView>& neighbours);

// Adds such points to the map, and to `recent`. Returns their number.
int create_points(SharedMap& map, KeyFrameId current, Sensor sensor, const MapperOptions& options,
                  RecentPoints& recent);

}  // namespace covis
