// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_detector.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

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

// The least similarity among the key frame's own neighbours.
double least_score(const Map& map, const KeyFrame& key_frame, KeyFrameId id) {
  double least = 1;
  const WeightsByWord weights(key_frame.words->words);
  for (const Neighbour& n : map.neighbours(id))
    least = std::min(least, weights.score(map.at(n.key_frame).words->words));
  return least;
}

// Adds what the database finds beside what is excluded: each place once, the best first, as many as are verified.
void add_places(const Map& map, const KeyFrame& key_frame, const std::function<bool(KeyFrameId)>& excluded,
                double min_score, std::vector<KeyFrameId>& places) {
  if (places.size() == LoopDetector::kCandidates) return;
  for (const auto& candidate : map.database().query(map, *key_frame.words, excluded, min_score)) {
    const KeyFrameId id = candidate.key_frame;
    const auto same = [&](KeyFrameId other) { return other == id || map.weight(other, id) >= kCovisibilityThreshold; };
    if (places.size() < LoopDetector::kCandidates && std::none_of(places.begin(), places.end(), same))
      places.push_back(id);
  }
}

}  // namespace

std::vector<KeyFrameId> LoopDetector::candidates(const Map& map, KeyFrameId current) const {
  const KeyFrame* key_frame = map.find(current);
  if (!key_frame || !key_frame->words) return {};
  if (last_loop_serial_ && key_frame->serial < *last_loop_serial_ + kBetweenLoops)
    return candidates_elsewhere(map, current);
  const double min_score = least_score(map, *key_frame, current);
  std::vector<KeyFrameId> result;
  for (const int steps : {kNearSteps, 1}) {
    // The camera has not come back to a place that was mapped a moment ago.
    const std::vector<KeyFrameId> near = within_steps(map, current, steps);
    const auto excluded = [&](KeyFrameId id) {
      const KeyFrame& place = map.at(id);
      return (place.submap == key_frame->submap && place.serial + kBetweenLoops > key_frame->serial) ||
             std::binary_search(near.begin(), near.end(), id);
    };
    add_places(map, *key_frame, excluded, min_score, result);
  }
  return result;
}

std::vector<KeyFrameId> LoopDetector::candidates_elsewhere(const Map& map, KeyFrameId current) {
  const KeyFrame* key_frame = map.find(current);
  if (!key_frame || !key_frame->words) return {};
  std::vector<KeyFrameId> result;
  const auto excluded = [&](KeyFrameId id) { return map.at(id).submap == key_frame->submap; };
  add_places(map, *key_frame, excluded, least_score(map, *key_frame, current), result);
  return result;
}

}  // namespace covis
