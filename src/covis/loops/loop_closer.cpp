// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_closer.h"

#include <algorithm>

#include "covis/core/time.h"
#include "covis/loops/loop_correction.h"

namespace covis {
LoopReport LoopCloser::process(KeyFrameId current) {
  LoopReport report;
  Stopwatch watch;
  const std::vector<KeyFrameId> places = detector_.candidates(*map_.read(), current);
  report.ms.query = watch.lap();
  report.candidates = static_cast<int>(places.size());
  if (places.empty()) return report;
  const std::optional<Loop> loop = recognise(current, places, report);
  report.ms.verify = watch.lap();
  if (!loop || !correct(current, *loop, report)) return report;
  report.fused = fuse_loop(map_, current, *loop, fuser_);
  {
    const auto map = map_.write();
    if (report.changed_map()) map->add_loop_edge(current, loop->place.key_frame);
    detector_.recognised(map->at(current).serial);
  }
  report.ms.correct = watch.lap();
  return report;
}

std::optional<Loop> LoopCloser::recognise(KeyFrameId current, const std::vector<KeyFrameId>& places,
                                          LoopReport& report) {
  for (const KeyFrameId& place : places) {
    const LoopCandidate candidate(*map_.read(), current, place);
    LoopVerdict verdict = verifier_.verify(candidate);
    report.evidence.matches = std::max(report.evidence.matches, verdict.evidence.matches);
    report.evidence.inliers = std::max(report.evidence.inliers, verdict.evidence.inliers);
    report.evidence.found_again = std::max(report.evidence.found_again, verdict.evidence.found_again);
    if (verdict.drift) report.drift = *verdict.drift;
    if (verdict.loop) return std::move(verdict.loop);
    report.refusal = verdict.refusal;
  }
  return std::nullopt;
}

bool LoopCloser::correct(KeyFrameId current, const Loop& loop, LoopReport& report) {
  if (loop.relation == LoopRelation::other_submap) {
    report.joined_key_frames = join_at_loop(map_, current, loop);
    if (report.joined_key_frames == 0) return false;
    report.outcome = LoopOutcome::joined;
  } else if (nothing_to_correct(loop, report.drift, map_.read()->camera())) {
    report.outcome = LoopOutcome::fused;
    return true;
  } else {
    report.ms.pose_graph = correct_loop(map_, current, loop, sensor_);
    report.outcome = LoopOutcome::closed;
  }
  report.loop = loop.place.key_frame;
  return true;
}

}  // namespace covis
