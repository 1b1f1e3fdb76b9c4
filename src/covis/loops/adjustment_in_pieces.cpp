// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/adjustment_in_pieces.h"

#include <algorithm>

#include "covis/core/reserve.h"
#include "covis/mapping/local_adjustment.h"
#include "covis/mapping/map_problem.h"

namespace covis {
namespace {

constexpr int kHolders = 200;  // key frames that hold a piece, at most

// Key frames that may join a piece, by slot: how many points they share with it.
class Growth {
 public:
  explicit Growth(const Map& map) : map_(map) {}
  void add(KeyFrameId id) {
    for (const Neighbour& n : map_.at(id).shared) {
      int& shared = at_slot(shared_, n.key_frame.slot);
      if (shared == 0) open_.push_back(n.key_frame);
      shared += n.weight;
    }
  }
  // The one that shares most of those for which `free` holds; among equal ones the lowest handle.
  template <typename Free>
  KeyFrameId next(const Free& free) {
    std::erase_if(open_, [&](KeyFrameId id) { return !free(id); });
    const auto best = std::max_element(open_.begin(), open_.end(), [&](KeyFrameId a, KeyFrameId b) {
      return std::pair(shared_[a.slot], b) < std::pair(shared_[b.slot], a);
    });
    return best == open_.end() ? KeyFrameId() : *best;
  }

 private:
  const Map& map_;
  std::vector<int> shared_;
  std::vector<KeyFrameId> open_;
};

}  // namespace

std::vector<std::vector<KeyFrameId>> pieces_of(const Map& map, uint32_t submap, size_t size, bool backwards) {
  std::vector<KeyFrameId> order = map.key_frames(submap);
  if (backwards) std::reverse(order.begin(), order.end());
  std::vector<uint8_t> left;  // by slot
  for (const KeyFrameId& id : order) at_slot(left, id.slot) = 1;
  const auto free = [&](KeyFrameId id) { return id.slot < left.size() && left[id.slot]; };
  std::vector<std::vector<KeyFrameId>> pieces;
  for (const KeyFrameId& first : order) {
    if (!free(first)) continue;
    pieces.emplace_back();
    Growth growth(map);
    for (KeyFrameId id = first; id.valid() && pieces.back().size() < size; id = growth.next(free)) {
      pieces.back().push_back(id);
      left[id.slot] = 0;
      growth.add(id);
    }
  }
  return pieces;
}

std::optional<AdjustedCost> adjust_in_pieces(SharedMap& shared, const std::vector<std::vector<KeyFrameId>>& pieces,
                                             int iterations) {
  AdjustedCost cost;
  bool adjusted = false;
  BundleAdjuster adjuster;
  for (const std::vector<KeyFrameId>& piece : pieces) {
    MapProblem problem;
    {
      const auto map = shared.read();
      const LocalWindow window = window_around(*map, piece, kHolders);
      problem.gather(*map, window.key_frames, window.moving);
    }
    if (std::find(problem.problem.fixed.begin(), problem.problem.fixed.end(), 1) == problem.problem.fixed.end())
      continue;  // no other key frame sees what it sees, so that none can hold it
    const BundleSummary done = adjuster.solve(problem.problem, {.iterations = iterations});
    if (!done.ok) continue;
    classify_observations(problem.problem);
    MapEdit edit(shared);
    problem.commit(edit);
    cost.before += done.initial_cost;
    cost.after += done.final_cost;
    adjusted = true;
  }
  return adjusted ? std::optional(cost) : std::nullopt;
}

}  // namespace covis
