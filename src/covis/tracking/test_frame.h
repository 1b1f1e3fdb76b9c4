// SPDX-License-Identifier: Apache-2.0
// For tests: frames of a scene of bare points, as tracking sees them.
#pragma once

#include "covis/map/test_point_scene.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// A frame of this view without matches, at a pose.
inline TrackedFrame frame_of(const PointScene::View& view, const SE3& T_cw, int64_t index = 0, Timestamp stamp = 0) {
  TrackedFrame frame;
  frame.start(view.features, index, stamp);
  frame.T_cw = T_cw;
  return frame;
}

// Matches every `every`-th feature that shows a point of the map with that point.
inline void match_points(TrackedFrame& frame, const PointScene::View& view, const SceneMap& world, size_t every = 1) {
  const auto map = world.shared.read();
  for (size_t f = 0; f < view.point.size(); f += every) {
    const MapPointId id = world.handles[view.point[f]];
    if (const MapPoint* point = map->find(id)) frame.set_match(f, id, point->position_w, PointSource::map);
  }
}

// The same features with something changed by edit(Features&).
template <class Edit>
PointScene::View edited(const PointScene::View& view, Edit&& edit) {
  auto features = std::make_shared<Features>(*view.features);
  edit(*features);
  return {features, view.point};
}

inline double distance(const SE3& a_cw, const SE3& b_cw) { return (a_cw.inverse().t() - b_cw.inverse().t()).norm(); }

}  // namespace covis
