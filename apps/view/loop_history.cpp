// SPDX-License-Identifier: Apache-2.0
#include "apps/view/loop_history.h"

#include <utility>

namespace covis::view {
namespace {

std::vector<PlaceRow> places_of(const Map& map) {
  std::vector<PlaceRow> places;
  places.reserve(map.key_frame_count());
  map.for_each_key_frame([&](KeyFrameId, const KeyFrame& key_frame) {
    const Eigen::Vector3f p = key_frame.T_cw.centre().cast<float>();
    places.push_back({key_frame.serial, {p.x(), p.y(), p.z()}, key_frame.submap});
  });
  return places;
}

}  // namespace

LoopHistory::Change LoopHistory::look(const SharedMap& map, const std::vector<MappingReport>& reports) {
  if (reports.empty()) return Change::none;
  uint64_t moves = 0;
  {
    const auto guard = map.read();
    moves = guard->moves();
    std::vector<PlaceRow> places = places_of(*guard);
    // The loop's report may come some frames after the map has moved.
    if (moves != moves_ && before_.empty()) before_ = std::move(now_);
    now_ = std::move(places);
  }
  moves_ = moves;
  Change change = Change::none;
  for (const MappingReport& report : reports) {
    if (report.loop.changed_map()) {
      const auto kind = report.loop.outcome == LoopOutcome::joined ? LoopPaths::Kind::joined : LoopPaths::Kind::closed;
      loops_.push_back({report.frame, kind, static_cast<float>(report.loop.drift.distance), std::move(before_), now_});
      before_.clear();
      change = Change::loops;
    }
    // The adjustment that follows a loop moves the map once more.
    if (report.full_adjustment_ms > 0 && !loops_.empty()) {
      loops_.back().after = now_;
      before_.clear();
      change = Change::loops;
    }
  }
  return change;
}

}  // namespace covis::view
