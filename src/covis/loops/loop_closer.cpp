// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_closer.h"

#include <utility>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/loops/link_strength.h"
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
    if (verdict.drift) report.drift = *verdict.drift;
    RefusedPlace refused{place, map_.read()->at(place).frame, verdict.refusal, verdict.evidence, verdict.drift, {}};
    if (verdict.claim && confirmed(current, *verdict.claim, refused)) {
      report.confirmed = true;
      report.unexplained = verdict.refusal == LoopRefusal::drift_too_great;
      verdict.loop = std::move(verdict.claim);
    }
    if (verdict.loop) {
      report.evidence = verdict.evidence;
      if (!report.unexplained) report.drift = weigh_against_drift(candidate, sensor_, *verdict.loop);
      return std::move(verdict.loop);
    }
    log(LogLevel::debug, describe(refused));
    report.evidence.raise_to(verdict.evidence);
    report.refused.push_back(std::move(refused));
  }
  return std::nullopt;
}

// A correction that no drift explains is right when the path since has a weak link, where the map hardly knows how the
// camera moved, and another place says the same.
bool LoopCloser::confirmed(KeyFrameId current, const Loop& claim, RefusedPlace& refused) {
  const auto map = map_.read();
  if (refused.why == LoopRefusal::neighbours_disagree)
    return consensus_.confirms(*map, current, claim, LoopConsensus::By::any_points);
  const KeyFrame& here = map->at(current);
  refused.link = LinkStrength(*map, here.submap).weakest(here.serial, map->at(claim.place.key_frame).serial);
  if (*refused.link >= options_.weak_link) return false;
  if (consensus_.confirms(*map, current, claim, LoopConsensus::By::other_points)) return true;
  refused.why = LoopRefusal::unconfirmed;
  return false;
}

bool LoopCloser::correct(KeyFrameId current, const Loop& loop, LoopReport& report) {
  if (loop.relation == LoopRelation::other_submap) {
    report.joined = join_at_loop(map_, current, loop);
    if (!report.joined) return false;
    report.fused = fuse_loop(map_, current, loop, fuser_);
    report.outcome = LoopOutcome::joined;
  } else if (nothing_to_correct(loop, map_.read()->camera())) {
    report.fused = fuse_loop(map_, current, loop, fuser_);
    report.outcome = LoopOutcome::fused;
    return true;
  } else {
    const int weak_link = report.unexplained ? options_.weak_link : 0;
    const LoopCorrection done = correct_loop(map_, current, loop, sensor_, fuser_, weak_link);
    report.fused = done.fused;
    report.new_edges = done.new_edges;
    report.ms.pose_graph = done.pose_graph_ms;
    report.outcome = LoopOutcome::closed;
  }
  report.loop = loop.place.key_frame;
  return true;
}

}  // namespace covis
