// SPDX-License-Identifier: Apache-2.0
#include "covis/features/quadtree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "covis/core/reserve.h"

namespace covis {
namespace {

bool before(const Corner& a, const Corner& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

}  // namespace

void Quadtree::split(const Node& node, std::vector<Node>& out) {
  const float mx = (node.x0 + node.x1) / 2, my = (node.y0 + node.y1) / 2;
  const int middle_x = static_cast<int>(std::ceil(mx)), middle_y = static_cast<int>(std::ceil(my));
  const auto quarter = [&](const Place& p) { return static_cast<size_t>(2 * (p.y >= middle_y) + (p.x >= middle_x)); };
  std::array<uint32_t, 5> start{};
  for (uint32_t k = node.first; k < node.last; ++k) {
    const Place& p = places_[k];
    scratch_[k - node.first] = p;
    ++start[quarter(p) + 1];
  }
  start[0] = node.first;
  for (size_t q = 1; q < 5; ++q) start[q] += start[q - 1];
  std::array<uint32_t, 4> next{start[0], start[1], start[2], start[3]};
  for (uint32_t k = 0; k < node.last - node.first; ++k) places_[next[quarter(scratch_[k])]++] = scratch_[k];
  for (size_t q = 0; q < 4; ++q) {
    if (start[q] == start[q + 1]) continue;
    out.push_back({q & 1 ? mx : node.x0, q & 2 ? my : node.y0, q & 1 ? node.x1 : mx, q & 2 ? node.y1 : my, start[q],
                   start[q + 1]});
  }
}

void Quadtree::make_roots(int x0, int y0, int x1, int y1, int most) {
  const int width = x1 - x0, height = y1 - y0;
  const int roots = std::clamp(static_cast<int>(std::lround(static_cast<double>(width) / height)), 1, most);
  const float root_width = static_cast<float>(width) / static_cast<float>(roots);
  const auto root_of = [&](const Corner& c) {
    return std::clamp(static_cast<int>(static_cast<float>(c.x - x0) / root_width), 0, roots - 1);
  };
  starts_.assign(static_cast<size_t>(roots) + 1, 0);
  reserve_ahead(root_of_, sorted_.size());
  root_of_.resize(sorted_.size());
  for (size_t k = 0; k < sorted_.size(); ++k) {
    root_of_[k] = static_cast<uint32_t>(root_of(sorted_[k]));
    ++starts_[root_of_[k] + 1];
  }
  nodes_.clear();
  for (size_t root = 0; root < static_cast<size_t>(roots); ++root) {
    starts_[root + 1] += starts_[root];
    if (starts_[root] == starts_[root + 1]) continue;
    const float left = static_cast<float>(x0) + static_cast<float>(root) * root_width;
    nodes_.push_back(
        {left, static_cast<float>(y0), left + root_width, static_cast<float>(y1), starts_[root], starts_[root + 1]});
  }
  reserve_ahead(places_, sorted_.size());
  places_.resize(sorted_.size());
  reserve_ahead(scratch_, sorted_.size());
  scratch_.resize(sorted_.size());
  for (uint32_t k = 0; k < sorted_.size(); ++k) places_[starts_[root_of_[k]]++] = {sorted_[k].x, sorted_[k].y, k};
}

void Quadtree::sort_by_size() {
  keys_.clear();
  for (size_t k = 0; k < nodes_.size(); ++k)
    keys_.push_back(static_cast<uint64_t>(~(nodes_[k].last - nodes_[k].first)) << 32 | k);
  std::sort(keys_.begin(), keys_.end());
  next_.clear();
  for (const uint64_t key : keys_) next_.push_back(nodes_[key & 0xFFFFFFFF]);
  std::swap(nodes_, next_);
}

void Quadtree::distribute(const std::vector<Corner>& corners, int x0, int y0, int x1, int y1, int budget,
                          std::vector<Corner>& kept) {
  kept.clear();
  if (corners.empty() || budget <= 0) return;
  reserve_ahead(sorted_, corners.size());
  sorted_ = corners;
  // The result must not depend on the input order; the detector's output is sorted this way already.
  if (!std::is_sorted(sorted_.begin(), sorted_.end(), before)) std::sort(sorted_.begin(), sorted_.end(), before);
  make_roots(x0, y0, x1, y1, budget);
  for (auto* nodes : {&nodes_, &next_}) reserve_ahead(*nodes, static_cast<size_t>(budget));
  reserve_ahead(keys_, static_cast<size_t>(budget));
  reserve_ahead(best_, static_cast<size_t>(budget));
  reserve_ahead(kept, static_cast<size_t>(budget) + 3);
  while (static_cast<int>(nodes_.size()) < budget) {
    const auto open =
        static_cast<int>(std::count_if(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.open(); }));
    if (open == 0) break;
    if (static_cast<int>(nodes_.size()) + 3 * open <= budget) {
      next_.clear();
      for (const Node& node : nodes_) {
        if (node.open()) {
          split(node, next_);
        } else {
          next_.push_back(node);
        }
      }
      std::swap(nodes_, next_);
      continue;
    }
    // In the last rounds the fullest nodes are split first, one by one, until the budget is reached.
    sort_by_size();
    next_.clear();
    size_t k = 0;
    auto count = static_cast<int>(nodes_.size());
    for (; k < nodes_.size() && nodes_[k].open() && count < budget; ++k) {
      const size_t held = next_.size();
      split(nodes_[k], next_);
      count += static_cast<int>(next_.size() - held) - 1;
    }
    next_.insert(next_.end(), nodes_.begin() + static_cast<ptrdiff_t>(k), nodes_.end());
    std::swap(nodes_, next_);
  }
  best_.clear();
  for (const Node& node : nodes_) {
    uint32_t best = places_[node.first].index;  // the first of equal scores: a node's places are sorted by y, then x
    for (uint32_t k = node.first + 1; k < node.last; ++k) {
      const uint32_t index = places_[k].index;
      if (sorted_[index].score > sorted_[best].score) best = index;
    }
    best_.push_back(best);
  }
  std::sort(best_.begin(), best_.end());
  for (const uint32_t index : best_) kept.push_back(sorted_[index]);
}

}  // namespace covis
