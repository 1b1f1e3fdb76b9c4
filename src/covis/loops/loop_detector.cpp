// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_detector.h"

#include <algorithm>
#include <iterator>

namespace covis {

namespace {

// The key frames within so many steps along edges of the covisibility graph, itself among them; sorted.
std::vector<KeyFrameId> within_steps(const Map& map, KeyFrameId from, int steps) {
  std::vector<KeyFrameId> reached{from}, last{from};
  for (int step = 0; step < steps; ++step) {
    std::vector<KeyFrameId> next;
    for (const KeyFrameId& id : last) {
      for (const Neighbour& n : map.neighbours(id)) next.push_back(n.key_frame);
    }
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    last.clear();
    std::set_difference(next.begin(), next.end(), reached.begin(), reached.end(), std::back_inserter(last));
    const auto middle = static_cast<ptrdiff_t>(reached.size());
    reached.insert(reached.end(), last.begin(), last.end());
    std::inplace_merge(reached.begin(), reached.begin() + middle, reached.end());
  }
  return reached;
}

}  // namespace

std::vector<KeyFrameId> LoopDetector::candidates(const Map& map, KeyFrameId current) const {
  const KeyFrame* key_frame = map.find(current);
  if (!key_frame || !key_frame->words) return {};
  if (last_loop_serial_ && key_frame->serial < *last_loop_serial_ + kBetweenLoops) return {};
  double min_score = 1;
  for (const Neighbour& n : map.neighbours(current))
    min_score = std::min(min_score, word_score(key_frame->words->words, map.at(n.key_frame).words->words));
  std::vector<KeyFrameId> result;
  const auto ask = [&](int steps) {
    if (result.size() == kCandidates) return;
    // The camera has not come back to a place that was mapped a moment ago.
    std::vector<KeyFrameId> excluded = within_steps(map, current, steps);
    map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& place) {
      if (place.submap == key_frame->submap && place.serial + kBetweenLoops > key_frame->serial) excluded.push_back(id);
    });
    std::sort(excluded.begin(), excluded.end());
    for (const auto& candidate : map.database().query(map, *key_frame->words, excluded, min_score)) {
      const KeyFrameId id = candidate.key_frame;
      const auto same = [&](KeyFrameId other) {
        return other == id || map.weight(other, id) >= kCovisibilityThreshold;
      };
      if (result.size() < kCandidates && std::none_of(result.begin(), result.end(), same)) result.push_back(id);
    }
  };
  ask(kNearSteps);
  ask(1);
  return result;
}

}  // namespace covis
