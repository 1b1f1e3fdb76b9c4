// SPDX-License-Identifier: Apache-2.0
#include "covis/features/quadtree.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace covis {
namespace {

bool before(const Corner& a, const Corner& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

}  // namespace

void Quadtree::split(const Node& node, std::vector<Node>& out) {
  const float mx = (node.x0 + node.x1) / 2, my = (node.y0 + node.y1) / 2;
  const auto quarter = [&](const Corner& c) { return static_cast<size_t>((c.y >= my ? 2 : 0) + (c.x >= mx ? 1 : 0)); };
  std::array<uint32_t, 5> start{};
  for (uint32_t k = node.first; k < node.last; ++k) ++start[quarter(order_[k]) + 1];
  start[0] = node.first;
  for (size_t q = 1; q < 5; ++q) start[q] += start[q - 1];
  std::array<uint32_t, 4> next{start[0], start[1], start[2], start[3]};
  scratch_.assign(order_.begin() + node.first, order_.begin() + node.last);
  for (const Corner& c : scratch_) order_[next[quarter(c)]++] = c;
  for (size_t q = 0; q < 4; ++q) {
    if (start[q] == start[q + 1]) continue;
    out.push_back({q & 1 ? mx : node.x0, q & 2 ? my : node.y0, q & 1 ? node.x1 : mx, q & 2 ? node.y1 : my, start[q], start[q + 1]});
  }
}

void Quadtree::distribute(const std::vector<Corner>& corners, int x0, int y0, int x1, int y1, int budget,
                          std::vector<Corner>& kept) {
  kept.clear();
  if (corners.empty() || budget <= 0) return;
  order_ = corners;
  std::sort(order_.begin(), order_.end(), before);  // the result must not depend on the order of input
  const int width = x1 - x0, height = y1 - y0;
  const int roots = std::max(1, static_cast<int>(std::lround(static_cast<double>(width) / height)));
  const float root_width = static_cast<float>(width) / static_cast<float>(roots);
  const auto root_of = [&](const Corner& c) {
    return std::clamp(static_cast<int>(static_cast<float>(c.x - x0) / root_width), 0, roots - 1);
  };
  std::stable_sort(order_.begin(), order_.end(), [&](const Corner& a, const Corner& b) { return root_of(a) < root_of(b); });
  nodes_.clear();
  for (uint32_t k = 0; k < order_.size();) {
    const int root = root_of(order_[k]);
    uint32_t end = k;
    while (end < order_.size() && root_of(order_[end]) == root) ++end;
    const float left = static_cast<float>(x0) + static_cast<float>(root) * root_width;
    nodes_.push_back({left, static_cast<float>(y0), left + root_width, static_cast<float>(y1), k, end});
    k = end;
  }
  while (static_cast<int>(nodes_.size()) < budget) {
    const auto open = static_cast<int>(std::count_if(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.open(); }));
    if (open == 0) break;
    next_.clear();
    if (static_cast<int>(nodes_.size()) + 3 * open <= budget) {
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
    // The last rounds: fullest first, one by one, until the budget is reached.
    std::stable_sort(nodes_.begin(), nodes_.end(),
                     [](const Node& a, const Node& b) { return a.last - a.first > b.last - b.first; });
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
  for (const Node& node : nodes_) {
    Corner best = order_[node.first];
    for (uint32_t k = node.first + 1; k < node.last; ++k) {
      const Corner& c = order_[k];
      if (c.score > best.score || (c.score == best.score && before(c, best))) best = c;
    }
    kept.push_back(best);
  }
  std::sort(kept.begin(), kept.end(), before);
}

}  // namespace covis
