// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_detector.h"

#include <algorithm>

namespace covis {

std::vector<KeyFrameId> LoopDetector::candidates(const Map& map, KeyFrameId current) const {
  const KeyFrame* key_frame = map.find(current);
  if (!key_frame || !key_frame->words) return {};
  if (last_loop_serial_ && key_frame->serial < *last_loop_serial_ + kBetweenLoops) return {};
  double min_score = 1;
  std::vector<KeyFrameId> excluded{current};
  for (const Neighbour& n : map.neighbours(current)) {
    excluded.push_back(n.key_frame);
    min_score = std::min(min_score, word_score(key_frame->words->words, map.at(n.key_frame).words->words));
  }
  std::sort(excluded.begin(), excluded.end());
  std::vector<KeyFrameId> result;
  for (const auto& candidate : map.database().query(map, *key_frame->words, excluded, min_score)) {
    // The camera has not come back to a place that was mapped a moment ago.
    const KeyFrame& place = map.at(candidate.key_frame);
    if (place.submap == key_frame->submap && place.serial + kBetweenLoops > key_frame->serial) continue;
    if (result.size() < kCandidates) result.push_back(candidate.key_frame);
  }
  return result;
}

}  // namespace covis
