// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/mapper.h"

#include <algorithm>

#include "covis/core/log.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

// Milliseconds since the last lap.
double lap(Stopwatch& watch) {
  const double ms = watch.ms();
  watch.restart();
  return ms;
}

}  // namespace

MappingReport Mapper::process(const KeyFrameRequest& request, const std::atomic<bool>* interrupt) {
  MappingReport report;
  report.frame = request.frame;
  Stopwatch total, watch;
  report.key_frame = insert(request);
  report.insert_ms = lap(watch);
  if (!report.key_frame.valid()) return report;
  add_words(report.key_frame);
  report.points_culled = cull_recent_points(report.key_frame);
  report.cull_points_ms = lap(watch);
  report.points_created = create_points(report.key_frame);
  report.create_ms = lap(watch);
  report.points_fused = fuse_neighbours(report.key_frame);
  report.fuse_ms = lap(watch);
  const bool enough = key_frames_of_its_submap(report.key_frame) > 2;
  if (enough && !(interrupt && interrupt->load())) {
    local_bundle_adjustment(report.key_frame, interrupt, report);
    report.ba_ms = lap(watch);
    report.key_frames_culled = cull_key_frames(report.key_frame);
    report.cull_key_frames_ms = lap(watch);
  }
  take_over_adjustment(report);
  close_loop(report.key_frame, report);
  adjust_focal(report.key_frame);
  report.loop_ms = lap(watch);
  report.total_ms = total.ms();
  return report;
}

size_t Mapper::key_frames_of_its_submap(KeyFrameId id) const {
  const auto map = map_.read();
  return map->submap(map->at(id).submap)->key_frames;
}

KeyFrameId Mapper::insert(const KeyFrameRequest& request) {
  auto features = std::make_shared<Features>(*request.features);  // a copy: the frame's have room for more
  const auto map = map_.write();
  SE3 T_cw = request.pose.T_cr;
  std::optional<RelativePose> reference;
  if (request.pose.key_frame.valid()) {
    reference = request.pose.resolved(*map);
    if (!reference) return {};
    T_cw = reference->T_cw(*map).normalized();
  }
  for (const PointCount& count : request.counts) {
    const MapPointId point = map->forwarded(count.point);
    if (!point.valid()) continue;
    map->count_visible(point, count.visible);
    map->count_found(point, count.found);
  }
  const KeyFrameId id = reference ? map->add_key_frame(request.frame, request.stamp, T_cw, std::move(features),
                                                       map->at(reference->key_frame).submap)
                                  : map->begin_submap(request.frame, request.stamp, T_cw, std::move(features));
  if (!id.valid()) return id;
  for (uint32_t feature = 0; feature < request.points.size(); ++feature) {
    const MapPointId point = map->forwarded(request.points[feature]);
    if (point.valid() && map->add_observation(point, id, feature)) map->refresh_point(point);
  }
  const SE3 T_wc = T_cw.inverse();
  const uint32_t serial = map->at(id).serial;
  for (const uint32_t feature : request.new_points) {
    const MapPointId point =
        map->add_point(T_wc * unproject_depth(map->camera(), *request.features, feature), id, feature);
    if (!point.valid()) continue;
    map->refresh_point(point);
    recent_.push_back({point, serial});
  }
  map->attach_to_tree(id);
  return id;
}

void Mapper::add_words(KeyFrameId id) {
  if (!vocabulary_) return;
  const FeaturesPtr features = map_.read()->at(id).features;
  auto words = std::make_shared<const Words>(vocabulary_->transform(features->descriptor));
  map_.write()->set_words(id, std::move(words));
}

int Mapper::cull_recent_points(KeyFrameId current) {
  const auto map = map_.write();
  const uint32_t serial = map->at(current).serial;
  // A view with depth tells as much as two without.
  const auto views = [&](const MapPoint& point) {
    int count = 0;
    for (const Observation& o : point.observations) {
      count += map->at(o.key_frame).features->has_depth(static_cast<int>(o.feature)) ? 2 : 1;
    }
    return count;
  };
  const int least_views = monocular() ? 2 : 3;
  int culled = 0;
  std::erase_if(recent_, [&](Recent& recent) {
    recent.point = map->forwarded(recent.point);
    const MapPoint* point = map->find(recent.point);
    if (!point) return true;
    const bool rarely_found = static_cast<double>(point->found) < options_.mapper.min_found_ratio * point->visible;
    const uint32_t age = serial - recent.serial;
    if (rarely_found || (age >= 2 && views(*point) <= least_views)) {
      map->erase_point(recent.point);
      ++culled;
      return true;
    }
    return age >= 3;
  });
  return culled;
}

int Mapper::cull_key_frames(KeyFrameId current) {
  constexpr int kObservers = 3;  // others that must see a point for it to be redundant
  const auto map = map_.write();
  const double close = options_.tracker.key_frame.close_depth_baselines * map->camera().baseline();
  int culled = 0;
  for (const Neighbour& neighbour : map->neighbours(current)) {
    const KeyFrameId id = neighbour.key_frame;
    if (map->is_root(id)) continue;
    const KeyFrame& key_frame = map->at(id);
    const Features& features = *key_frame.features;
    int points = 0, redundant = 0;
    for (size_t i = 0; i < key_frame.points.size(); ++i) {
      if (!key_frame.points[i].valid()) continue;
      if (!monocular() && !(features.depth[i] > 0 && features.depth[i] <= close)) continue;
      ++points;
      const MapPoint& point = map->at(key_frame.points[i]);
      if (static_cast<int>(point.observations.size()) <= kObservers) continue;
      int others = 0;
      for (const Observation& observation : point.observations) {
        if (observation.key_frame == id) continue;
        const int level = map->at(observation.key_frame).features->level[observation.feature];
        if (level <= features.level[i] + 1 && ++others >= kObservers) break;
      }
      if (others >= kObservers) ++redundant;
    }
    if (points > 0 && redundant > options_.mapper.cull_redundancy * points && map->erase_key_frame(id)) ++culled;
  }
  return culled;
}

// The result of a full bundle adjustment is taken over a fixed number of key frames later, so that it does not depend
// on how fast the machine is; in real time as soon as it is there.
void Mapper::take_over_adjustment(MappingReport& report) {
  if (!global_.running()) return;
  --global_left_;
  if (options_.realtime ? !global_.ready() : global_left_ > 0) return;
  const GlobalAdjuster::Outcome outcome = global_.commit(map_);
  if (!outcome.focal) report.loop.full_ba_ms = outcome.ms;
}

void Mapper::adjust_focal(KeyFrameId current) {
  // Stereo's baseline times focal length would have to follow.
  if (options_.sensor == Sensor::stereo || !options_.mapper.refine_focal || global_.running()) return;
  const std::optional<int> age = focal_.ask(*map_.read());
  if (!age) return;
  global_.start(map_, current, FocalSchedule::kIterations, given_fx_);
  global_left_ = *age;
}

void Mapper::close_loop(KeyFrameId current, MappingReport& report) {
  if (!vocabulary_ || !options_.loop.close) return;
  if (!closer_.process(current, report.loop)) return;
  global_.abandon();
  if (options_.loop.ba_iterations > 0) global_.start(map_, current, options_.loop.ba_iterations);
  global_left_ = options_.loop.ba_key_frames;
}

void Mapper::finish() {
  if (global_.running()) global_.commit(map_);
}

void Mapper::discard(uint32_t submap) {
  const auto map = map_.write();
  map->erase_submap(submap);
  if (!map->submaps().empty()) return;
  closer_.reset();
  focal_.restart(*map);
}

}  // namespace covis
