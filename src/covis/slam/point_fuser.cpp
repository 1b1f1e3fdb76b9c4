// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/point_fuser.h"

#include <algorithm>

#include "covis/slam/point_geometry.h"

namespace covis {

int PointFuser::fuse(SharedMap& shared, KeyFrameId target, const std::vector<MapPointId>& points,
                     const FuseOptions& options) {
  FeaturesPtr features;
  queries_.clear();
  descriptors_.clear();
  candidates_.clear();
  {
    const auto map = shared.read();
    const KeyFrame* key_frame = map->find(target);
    if (!key_frame) return 0;
    features = key_frame->features;
    const SE3& T_cw = key_frame->T_cw;
    const Eigen::Vector3d centre = T_cw.centre();
    std::vector<MapPointId> observed;
    for (const MapPointId& id : key_frame->points) {
      if (id.valid()) observed.push_back(id);
    }
    std::sort(observed.begin(), observed.end());
    for (const MapPointId& held : points) {
      const MapPointId id = map->forwarded(held);
      const MapPoint* point = map->find(id);
      if (!point || std::binary_search(observed.begin(), observed.end(), id)) continue;
      const auto view = predict_view({point->position_w, point->normal_w.cast<float>(), point->d_min, point->d_max},
                                     T_cw, centre, map->camera(), *features);
      if (!view) continue;
      const float scale = features->pyramid->scale[static_cast<size_t>(view->level)];
      queries_.push_back({view->u, view->v, view->u_right, static_cast<float>(options.window) * scale, view->level - 1,
                          view->level, nullptr});
      descriptors_.push_back(point->descriptor);
      candidates_.push_back(id);
    }
  }
  for (size_t q = 0; q < queries_.size(); ++q) queries_[q].descriptor = &descriptors_[q];
  const WindowMatchOptions match_options{.max_distance = kHammingLow,
                                         .ratio = 1,
                                         .max_chi2_mono = options.check_error ? static_cast<float>(kChi2Mono) : 0,
                                         .max_chi2_stereo = options.check_error ? static_cast<float>(kChi2Stereo) : 0};
  if (matcher_.match(*features, queries_, {}, match_options, match_) == 0) return 0;

  const auto map = shared.write();
  if (!map->find(target)) return 0;
  int fused = 0;
  for (size_t q = 0; q < queries_.size(); ++q) {
    if (match_[q] < 0) continue;
    const MapPointId id = map->forwarded(candidates_[q]);
    if (!map->find(id)) continue;
    const auto feature = static_cast<uint32_t>(match_[q]);
    const MapPointId present = map->at(target).points[feature];
    if (!present.valid()) {
      if (map->add_observation(id, target, feature)) ++fused;
    } else if (present != id) {
      const bool keep_present =
          !options.keep_given && map->at(present).observations.size() > map->at(id).observations.size();
      if (keep_present ? map->replace_point(id, present) : map->replace_point(present, id)) ++fused;
    }
  }
  return fused;
}

}  // namespace covis
