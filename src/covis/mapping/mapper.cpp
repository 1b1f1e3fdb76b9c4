// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/mapper.h"

#include "covis/core/time.h"
#include "covis/mapping/initial_map.h"
#include "covis/mapping/key_frame_culling.h"
#include "covis/mapping/key_frame_insertion.h"
#include "covis/mapping/local_adjustment.h"
#include "covis/mapping/observation_alignment.h"
#include "covis/mapping/point_creation.h"
#include "covis/mapping/point_fusion.h"

namespace covis {

MapperReport Mapper::process(const KeyFrameRequest& request, const std::atomic<bool>* interrupt) {
  MapperReport report;
  report.frame = request.frame;
  Stopwatch watch;
  const size_t recent = recent_.size();
  const KeyFrameId current = report.key_frame = insert_key_frame(map_, request, recent_);
  report.ms.insert = watch.lap();
  if (!current.valid()) return report;
  report.counts.points_created = static_cast<int>(recent_.size() - recent);  // by their depth
  add_words(current);
  report.counts.points_culled = recent_.cull(map_, current, sensor_, options_.min_found_ratio);
  report.ms.cull_points = watch.lap();
  report.counts.points_created += create_points(map_, current, sensor_, options_, recent_);
  report.ms.create = watch.lap();
  report.counts.points_fused = fuse_neighbours(map_, current, sensor_, options_, fuser_);
  report.ms.fuse = watch.lap();
  align_observations(map_, current);
  report.ms.align = watch.lap();
  if (!enough_to_adjust(current) || (interrupt && interrupt->load())) return report;
  const bool learns_noise = options_.estimate_depth_noise && !request.doubted_depth;
  report.adjustment =
      adjust_locally(map_, current, options_, adjuster_, learns_noise ? &depth_noise_ : nullptr, interrupt);
  report.ms.adjust = watch.lap();
  report.counts.key_frames_culled = cull_key_frames(map_, current, sensor_, options_.cull_redundancy, close_depth_);
  report.ms.cull_key_frames = watch.lap();
  return report;
}

MapperReport Mapper::initialise(const InitialMapRequest& request) {
  MapperReport report;
  report.frame = request.second.frame;
  const auto made = make_initial_map(map_, request, adjuster_, recent_);
  if (!made) return report;
  report.first = made->first;
  report.key_frame = made->second;
  report.counts.points_created = made->points;
  add_words(report.first);
  add_words(report.key_frame);
  return report;
}

bool Mapper::enough_to_adjust(KeyFrameId id) const {
  constexpr size_t kLeast = 3;  // key frames of the submap
  const auto map = map_.read();
  return map->submap(map->at(id).submap)->key_frames >= kLeast;
}

void Mapper::add_words(KeyFrameId id) {
  if (!vocabulary_) return;
  const FeaturesPtr features = map_.read()->at(id).features;
  auto words = std::make_shared<const Words>(vocabulary_->transform(features->descriptor));
  map_.write()->set_words(id, std::move(words));
}

}  // namespace covis
