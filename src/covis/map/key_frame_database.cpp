// SPDX-License-Identifier: Apache-2.0
#include "covis/map/key_frame_database.h"

#include <algorithm>

#include "covis/core/reserve.h"
#include "covis/map/map.h"

namespace covis {
namespace {

constexpr double kSharedWords = 0.8;  // a share of the greatest number of shared words that a candidate must share
constexpr double kGroupScore = 0.75;  // a share of the best group's score that a group must reach
constexpr int kGroup = 10;            // covisible key frames that make a group

}  // namespace

std::vector<uint32_t>& KeyFrameDatabase::list_of(uint32_t word) {
  if (word >= list_of_.size()) list_of_.resize(word + size_t{1});
  uint32_t& list = list_of_[word];
  if (list == 0) {
    lists_.emplace_back();
    list = static_cast<uint32_t>(lists_.size());
  }
  return lists_[list - 1];
}

void KeyFrameDatabase::add(KeyFrameId id, const Words& words) {
  for (const WordWeight& w : words.words) {
    std::vector<uint32_t>& holders = list_of(w.word);
    reserve_one_more(holders);
    holders.insert(std::lower_bound(holders.begin(), holders.end(), id.slot), id.slot);
  }
}

void KeyFrameDatabase::erase(KeyFrameId id, const Words& words) {
  for (const WordWeight& w : words.words) {
    if (w.word >= list_of_.size() || list_of_[w.word] == 0) continue;
    std::vector<uint32_t>& holders = lists_[list_of_[w.word] - 1];
    const auto at = std::lower_bound(holders.begin(), holders.end(), id.slot);
    if (at != holders.end() && *at == id.slot) holders.erase(at);
  }
}

const std::vector<uint32_t>& KeyFrameDatabase::holders(uint32_t word) const {
  static const std::vector<uint32_t> none;
  return word < list_of_.size() && list_of_[word] > 0 ? lists_[list_of_[word] - 1] : none;
}

std::vector<KeyFrameDatabase::Candidate> KeyFrameDatabase::query(const Map& map, const Words& words,
                                                                 const std::function<bool(KeyFrameId)>& excluded,
                                                                 double min_score) const {
  size_t slots = 0;
  for (const WordWeight& w : words.words) {
    if (const auto& held = holders(w.word); !held.empty()) slots = std::max(slots, held.back() + size_t{1});
  }
  std::vector<int> shared(slots);  // words, by slot
  for (const WordWeight& w : words.words) {
    for (const uint32_t slot : holders(w.word)) ++shared[slot];
  }
  const auto left_out = [&](uint32_t slot) { return excluded && excluded(map.key_frame_in(slot)); };
  int most = 0;
  for (uint32_t slot = 0; slot < shared.size(); ++slot) {
    if (shared[slot] > most && !left_out(slot)) most = shared[slot];
  }
  const WeightsByWord weights(words.words);
  std::vector<Candidate> scored;  // sorted by handle
  for (uint32_t slot = 0; slot < shared.size(); ++slot) {
    if (shared[slot] == 0 || shared[slot] < kSharedWords * most || left_out(slot)) continue;
    const KeyFrameId id = map.key_frame_in(slot);
    const double score = weights.score(map.at(id).words->words);
    if (score >= min_score) scored.push_back({id, score});
  }
  struct Group {
    Candidate best;
    double sum = 0;
  };
  std::vector<Group> groups;
  double best_sum = 0;
  for (const Candidate& candidate : scored) {
    Group group{candidate, candidate.score};
    for (const Neighbour& n : map.best_neighbours(candidate.key_frame, kGroup)) {
      const auto at = std::lower_bound(scored.begin(), scored.end(), n.key_frame,
                                       [](const Candidate& c, KeyFrameId id) { return c.key_frame < id; });
      if (at == scored.end() || at->key_frame != n.key_frame) continue;
      group.sum += at->score;
      if (at->score > group.best.score) group.best = *at;
    }
    best_sum = std::max(best_sum, group.sum);
    groups.push_back(group);
  }
  std::stable_sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.sum > b.sum; });
  std::vector<Candidate> result;
  for (const Group& group : groups) {
    if (group.sum < kGroupScore * best_sum) break;
    const auto same = [&](const Candidate& c) { return c.key_frame == group.best.key_frame; };
    if (std::none_of(result.begin(), result.end(), same)) result.push_back(group.best);
  }
  return result;
}

}  // namespace covis
