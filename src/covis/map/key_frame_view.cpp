// SPDX-License-Identifier: Apache-2.0
#include "covis/map/key_frame_view.h"

#include <algorithm>
#include <utility>

#include "covis/core/quantile.h"
#include "covis/core/reserve.h"

namespace covis {

KeyFrameView::KeyFrameView(const Map& map, KeyFrameId key_frame) {
  // No more than that: a view made so is not refilled.
  const size_t count = map.at(key_frame).points.size();
  points.reserve(count);
  positions.reserve(count);
  copy(map, key_frame);
}

void KeyFrameView::copy(const Map& map, KeyFrameId key_frame) {
  const KeyFrame& source = map.at(key_frame);
  id = key_frame;
  submap = source.submap;
  T_cw = source.T_cw;
  scale = source.scale;
  features = source.features;
  reserve_ahead(points, source.points.size());
  points = source.points;
  reserve_ahead(positions, points.size());
  positions.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].valid()) positions[i] = map.at(points[i]).position_w;
  }
}

std::vector<uint8_t> features_with_point(const std::vector<MapPointId>& points) {
  std::vector<uint8_t> with(points.size());
  std::transform(points.begin(), points.end(), with.begin(), [](MapPointId id) { return id.valid(); });
  return with;
}

std::vector<uint8_t> features_without_point(const std::vector<MapPointId>& points) {
  std::vector<uint8_t> without(points.size());
  std::transform(points.begin(), points.end(), without.begin(), [](MapPointId id) { return !id.valid(); });
  return without;
}

double median_depth(const KeyFrameView& view) {
  std::vector<double> depths;
  for (size_t i = 0; i < view.points.size(); ++i) {
    if (view.points[i].valid()) depths.push_back((view.T_cw * view.positions[i]).z());
  }
  return quantile(std::move(depths), 0.5);
}

}  // namespace covis
