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

ShutterAdjustment::Part::Part(const Map& map, MapProblem of_submap) : submap(std::move(of_submap)) {
  for (const KeyFrameId& id : submap.key_frames) features.push_back(map.at(id).features);
  for (const BundleObservation& o : submap.problem.observations) {
    const MapPoint& point = map.at(submap.points[static_cast<size_t>(o.point)]);
    feature.push_back(point.feature_in(submap.key_frames[static_cast<size_t>(o.pose)]));
  }
}

bool ShutterAdjustment::Part::adjust(const Pinhole& camera, const std::atomic<bool>& interrupt) {
  BundleProblem& problem = submap.problem;
  problem.camera = camera;
  for (FeaturesPtr& f : features)
    if (!straight_for(*f, camera)) f = straightened(*f, camera);
  for (size_t k = 0; k < problem.observations.size(); ++k) {
    BundleObservation& o = problem.observations[k];
    const Features& f = *features[static_cast<size_t>(o.pose)];
    o.u = f.x[feature[k]];
    o.v = f.y[feature[k]];
  }
  BundleAdjuster adjuster;
  const BundleSummary summary = adjuster.solve(problem, {.iterations = 20, .interrupt = &interrupt});
  classify_observations(problem);
  return summary.ok && !summary.interrupted;
}

std::unique_ptr<ShutterAdjustment> ShutterAdjustment::of(const Map& map, double row_time) {
  auto job = std::unique_ptr<ShutterAdjustment>(new ShutterAdjustment(row_time));
  for (const Submap& submap : map.submaps()) {
    std::optional<MapProblem> problem = copy_submap(map, submap.root);
    if (problem) job->parts_.emplace_back(map, std::move(*problem));
  }
  if (job->parts_.empty()) return nullptr;
  return job;
}

bool ShutterAdjustment::run(const std::atomic<bool>& interrupt) {
  for (Part& part : parts_) {
    Pinhole camera = part.submap.problem.camera;
    camera.row_time = row_time_;
    if (!part.adjust(camera, interrupt)) return false;
  }
  return true;
}

std::optional<KeyFrameMoves> ShutterAdjustment::apply(SharedMap& map) const {
  Pinhole camera = map.read()->camera();
  const bool is_first = camera.row_time == 0;
  camera.row_time = row_time_;
  bool applied = false;
  for (const Part& part : parts_) applied |= apply_submap(part.submap, map, camera).has_value();
  if (!applied) return std::nullopt;
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "rolling shutter %s: %.1f microseconds from row to row",
                is_first ? "found" : "corrected", 1e6 * row_time_);
  log(LogLevel::info, row_time_ != 0 ? text.data() : "what was taken for a rolling shutter is none");
  return KeyFrameMoves{};  // frames have ShutterResponse
}

}  // namespace covis
