// SPDX-License-Identifier: Apache-2.0
// A key frame copied out of the map: enough to track against, match with and triangulate from without holding the
// map's lock. The one copy of a key frame that tracking, mapping and loop closing make.
#pragma once

#include <vector>

#include "covis/map/map.h"

namespace covis {

struct KeyFrameView {
  KeyFrameId id;
  uint32_t submap = 0;  // id of its submap
  SE3 T_cw;
  double scale = 1;  // KeyFrame::scale
  FeaturesPtr features;
  std::vector<MapPointId> points;          // for each feature its map point, or an invalid handle
  std::vector<Eigen::Vector3d> positions;  // for each feature, world, meaningful where points is valid

  KeyFrameView() = default;
  KeyFrameView(const Map& map, KeyFrameId key_frame);
  // Copies a live key frame, into the memory there is.
  void copy(const Map& map, KeyFrameId key_frame);
};

// For each feature 1 where it has a map point, else 0.
std::vector<uint8_t> features_with_point(const std::vector<MapPointId>& points);
// For each feature 1 where it has none, else 0.
std::vector<uint8_t> features_without_point(const std::vector<MapPointId>& points);
// The median depth of its points, in the map's unit; 0 without points.
double median_depth(const KeyFrameView& view);

}  // namespace covis
