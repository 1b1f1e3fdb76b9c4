// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/point_fuser.h"

#include <algorithm>

namespace covis {

int PointFuser::fuse(SharedMap& shared, KeyFrameId target, const std::vector<MapPointId>& points,
                     const FuseOptions& options, FuseMemory* memory) {
  FeaturesPtr features;
  SE3 T_cw;
  Pinhole camera;
  candidates_.clear();
  {
    const auto map = shared.read();
    const KeyFrame* key_frame = map->find(target);
    if (!key_frame) return 0;
    features = key_frame->features;
    T_cw = key_frame->T_cw;
    camera = map->camera();
    const Eigen::Vector3d centre_w = T_cw.centre();
    const auto in_view = [&](const MapPoint& point) {
      return predict_view(ViewablePoint(point), T_cw, centre_w, camera, *features).has_value();
    };
    for (const MapPointId& held : points) {
      const MapPointId id = map->forwarded(held);
      if (memory && memory->has(target, id)) continue;
      const MapPoint* point = map->find(id);
      if (!point || point->seen_by(target)) continue;
      // The points of a neighbourhood are many, and few of them are in view.
      if (in_view(*point)) {
        candidates_.add(id, *point);
      } else if (memory) {
        memory->add(target, id);
      }
    }
  }
  matcher_.match(candidates_, {camera, *features, T_cw}, MatchGate::fusion(options.window, options.error));
  if (memory) {
    for (const uint32_t k : matcher_.unlike()) memory->add(target, candidates_.id[k]);
  }
  if (matcher_.matches().empty()) return 0;

  // No MapEdit: callers fuse into several key frames, and refresh the points that got observations at the end. (One
  // that replaces another is refreshed by the map at once.)
  const auto map = shared.write();
  if (!map->find(target)) return 0;
  int fused = 0;
  for (const PointMatch& match : matcher_.matches()) {
    const MapPointId id = map->forwarded(candidates_.id[match.point]);
    if (!map->find(id)) continue;
    const MapPointId present = map->at(target).points[match.feature];
    if (!present.valid()) {
      if (map->add_observation(id, target, match.feature)) ++fused;
    } else if (present != id) {
      const bool keep_present = options.keep == FuseKeep::more_observed &&
                                map->at(present).observations.size() > map->at(id).observations.size();
      if (keep_present ? map->replace_point(id, present) : map->replace_point(present, id)) ++fused;
    }
  }
  return fused;
}

}  // namespace covis
