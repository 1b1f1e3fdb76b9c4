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

// Triangulates the features of a new key frame that have no point, with one neighbour after the other: a feature gets
// its point with the first neighbour that shows it. One copy of a neighbour at a time is enough.
class PointTriangulation {
 public:
  PointTriangulation(const Pinhole& camera, Sensor sensor, KeyFrameView current);
  // A neighbour too near the new key frame is passed over.
  void add(const KeyFrameView& neighbour);

  const std::vector<TriangulatedPoint>& made() const { return made_; }

 private:
  const Pinhole camera_;
  const Sensor sensor_;
  KeyFrameView current_;
  std::vector<uint8_t> is_free_;  // for each feature of the new key frame 1 while it has no point
  std::vector<TriangulatedPoint> made_;
};

// Adds such points to the map, and to `recent`. Returns their number.
int create_points(SharedMap& map, KeyFrameId current, Sensor sensor, const MapperOptions& options,
                  RecentPoints& recent);

}  // namespace covis
