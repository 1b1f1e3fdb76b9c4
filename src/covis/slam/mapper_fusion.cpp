// SPDX-License-Identifier: Apache-2.0
// Merging duplicate points between a new key frame and its neighbourhood (ORB-SLAM, VI-C; ORB-SLAM2, III-C).
#include <algorithm>

#include "covis/slam/mapper.h"
#include "covis/slam/point_geometry.h"

namespace covis {

int Mapper::fuse_neighbours(KeyFrameId current) {
  std::vector<KeyFrameId> targets;
  std::vector<MapPointId> own;
  {
    const auto map = map_.read();
    const int count = monocular() ? options_.mapper.create_neighbours_mono : options_.mapper.create_neighbours;
    const auto add = [&](KeyFrameId id) {
      if (id != current && std::find(targets.begin(), targets.end(), id) == targets.end()) targets.push_back(id);
    };
    for (const Neighbour& first : map->best_neighbours(current, count)) {
      add(first.key_frame);
      for (const Neighbour& second : map->best_neighbours(first.key_frame, options_.mapper.fuse_second_neighbours)) {
        add(second.key_frame);
      }
    }
    for (const MapPointId& id : map->at(current).points) {
      if (id.valid()) own.push_back(id);
    }
  }
  int fused = 0;
  for (const KeyFrameId& target : targets) fused += fuse_into(target, own);

  // And the neighbourhood's points into the new key frame.
  std::vector<MapPointId> others;
  {
    const auto map = map_.read();
    for (const KeyFrameId& target : targets) {
      const KeyFrame* key_frame = map->find(target);
      if (!key_frame) continue;
      for (const MapPointId& id : key_frame->points) {
        if (id.valid()) others.push_back(id);
      }
    }
  }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  fused += fuse_into(current, others);

  const auto map = map_.write();
  const std::vector<MapPointId> points = map->at(current).points;
  for (const MapPointId& id : points) {
    if (id.valid()) map->refresh_point(id);
  }
  return fused;
}

int Mapper::fuse_into(KeyFrameId target, const std::vector<MapPointId>& points) {
  FeaturesPtr features;
  queries_.clear();
  descriptors_.clear();
  candidates_.clear();
  {
    const auto map = map_.read();
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
                                     T_cw, centre, *features);
      if (!view) continue;
      const float scale = features->pyramid->scale[static_cast<size_t>(view->level)];
      queries_.push_back({view->u, view->v, view->u_right, static_cast<float>(options_.mapper.fuse_window) * scale,
                          view->level - 1, view->level, nullptr});
      descriptors_.push_back(point->descriptor);
      candidates_.push_back(id);
    }
  }
  for (size_t q = 0; q < queries_.size(); ++q) queries_[q].descriptor = &descriptors_[q];
  const WindowMatchOptions options{.max_distance = kHammingLow,
                                   .ratio = 1,
                                   .max_chi2_mono = static_cast<float>(kChi2Mono),
                                   .max_chi2_stereo = static_cast<float>(kChi2Stereo)};
  if (matcher_.match(*features, queries_, {}, options, match_) == 0) return 0;

  const auto map = map_.write();
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
      // The one with more observations stays.
      const bool keep_present = map->at(present).observations.size() > map->at(id).observations.size();
      if (keep_present ? map->replace_point(id, present) : map->replace_point(present, id)) ++fused;
    }
  }
  return fused;
}

}  // namespace covis
