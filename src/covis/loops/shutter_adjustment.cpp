// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/shutter_adjustment.h"

#include <array>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <utility>

#include "covis/core/log.h"
#include "covis/features/straightening.h"
#include "covis/loops/submap_adjustment.h"

namespace covis {

std::unique_ptr<ShutterAdjustment> ShutterAdjustment::of(const Map& map, KeyFrameId key_frame, double row_time) {
  std::optional<MapProblem> submap = copy_submap(map, key_frame);
  if (!submap) return nullptr;
  auto job = std::unique_ptr<ShutterAdjustment>(new ShutterAdjustment(std::move(*submap), row_time));
  for (const KeyFrameId& id : job->submap_.key_frames) job->features_.push_back(map.at(id).features);
  for (const BundleObservation& o : job->submap_.problem.observations) {
    const MapPoint& point = map.at(job->submap_.points[static_cast<size_t>(o.point)]);
    job->feature_.push_back(point.feature_in(job->submap_.key_frames[static_cast<size_t>(o.pose)]));
  }
  return job;
}

bool ShutterAdjustment::run(const std::atomic<bool>& interrupt) {
  BundleProblem& problem = submap_.problem;
  problem.camera.row_time = row_time_;
  for (FeaturesPtr& features : features_)
    if (!straight_for(*features, problem.camera)) features = straightened(*features, problem.camera);
  for (size_t k = 0; k < problem.observations.size(); ++k) {
    BundleObservation& o = problem.observations[k];
    const Features& f = *features_[static_cast<size_t>(o.pose)];
    o.u = f.x[feature_[k]];
    o.v = f.y[feature_[k]];
  }
  BundleAdjuster adjuster;
  const BundleSummary summary = adjuster.solve(problem, {.iterations = 20, .interrupt = &interrupt});
  classify_observations(problem);
  return summary.ok && !summary.interrupted;
}

bool ShutterAdjustment::apply(SharedMap& map) const {
  Pinhole camera = map.read()->camera();
  camera.row_time = row_time_;
  if (!apply_submap(submap_, map, camera)) return false;
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "rolling shutter found: %.1f microseconds from row to row", 1e6 * row_time_);
  log(LogLevel::info, row_time_ != 0 ? text.data() : "what was taken for a rolling shutter is none");
  return true;
}

}  // namespace covis
