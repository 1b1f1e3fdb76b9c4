// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/last_frame.h"

#include "covis/matching/point_geometry.h"

namespace covis {

void LastFrame::become(const Map& map, KeyFrameId key_frame) {
  pose = RelativePose::at(map, key_frame);
  submap = map.at(key_frame).submap;
  frame.T_cw = map.at(key_frame).T_cw;
}

void LastFrame::add_depth_points(const std::vector<uint32_t>& features, const Pinhole& camera) {
  const SE3 T_wl = frame.T_cw.inverse();
  for (const uint32_t i : features) {
    if (frame.on_map(i)) continue;
    frame.source[i] = PointSource::depth;
    frame.positions[i] = T_wl * unproject_depth(camera, *frame.features, i);
  }
}

void LastFrame::take_points(const Map& map, KeyFrameId key_frame) {
  const KeyFrame* made = map.find(key_frame);
  if (!made) return;
  for (size_t i = 0; i < made->points.size(); ++i) {
    const MapPointId id = made->points[i];
    if (id.valid()) {
      frame.set_match(i, id, map.at(id).position_w, PointSource::map);
    } else {
      frame.drop_match(i);
    }
  }
}

void LastFrame::refresh_points(const Map& map) {
  for (size_t i = 0; i < frame.points.size(); ++i) {
    if (!frame.on_map(i)) continue;
    const MapPointId id = map.forwarded(frame.points[i]);
    if (const MapPoint* point = map.find(id)) {
      frame.set_match(i, id, point->position_w, PointSource::map);
    } else {
      frame.drop_match(i);
    }
  }
}

}  // namespace covis
