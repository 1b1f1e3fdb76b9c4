// SPDX-License-Identifier: Apache-2.0
#include "covis/io/stamp_pairs.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <span>
#include <tuple>

namespace covis::io {
namespace {

enum class List { images, others };

// The entries of one list with one stamp that are left, in the order of their indices.
struct Entries {
  Timestamp stamp;
  List list;
  std::span<const size_t> left;
};

// Indices into the list by stamp, and those of one stamp in their order.
std::vector<size_t> by_stamp(const std::vector<Timestamp>& stamps) {
  std::vector<size_t> order(stamps.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return stamps[a] < stamps[b]; });
  return order;
}

void add_entries(const std::vector<Timestamp>& stamps, const std::vector<size_t>& order, List list,
                 std::vector<Entries>& entries) {
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const Timestamp stamp = stamps[order[begin]];
    while (end < order.size() && stamps[order[end]] == stamp) ++end;
    entries.push_back({stamp, list, std::span(order).subspan(begin, end - begin)});
  }
}

// The nearest two of all that are left are neighbours in time. So it is enough to keep the pairs of neighbours, and to
// add the new ones when a pair goes.
class NearestFirst {
 public:
  explicit NearestFirst(std::vector<Entries> entries) : entries_(std::move(entries)) {
    std::sort(entries_.begin(), entries_.end(),
              [](const Entries& a, const Entries& b) { return std::tie(a.stamp, a.list) < std::tie(b.stamp, b.list); });
    for (size_t at = 0; at < entries_.size(); ++at) neighbours_.push_back({at - 1, at + 1});
    for (size_t at = 0; at + 1 < entries_.size(); ++at) add_pair(at, at + 1);
  }

  std::vector<std::pair<size_t, size_t>> pairs() {
    std::map<size_t, size_t> other_of;
    for (; !nearest_.empty(); nearest_.pop()) {
      const auto [difference, image, stamp, other, image_at, other_at] = nearest_.top();
      if (!is_first(image_at, image) || !is_first(other_at, other)) continue;  // one of them has its pair
      other_of[image] = other;
      for (const size_t at : {image_at, other_at}) {
        entries_[at].left = entries_[at].left.subspan(1);
        if (entries_[at].left.empty()) unlink(at);
      }
      for (const size_t at : {image_at, other_at}) {
        add_pair(neighbours_[at].before, entries_[at].left.empty() ? neighbours_[at].after : at);
        add_pair(at, neighbours_[at].after);
      }
    }
    return {other_of.begin(), other_of.end()};
  }

 private:
  struct Neighbours {
    size_t before, after;  // beyond all entries: there is none
  };
  // Difference, index of the image, stamp and index of the other, and where both are in entries_. Of equally near ones
  // that with the first image goes first, then that with the earlier other.
  using Candidate = std::tuple<Timestamp, size_t, Timestamp, size_t, size_t, size_t>;

  bool is_first(size_t at, size_t index) const {
    return !entries_[at].left.empty() && entries_[at].left.front() == index;
  }

  void unlink(size_t at) {
    const auto [before, after] = neighbours_[at];
    if (before < entries_.size()) neighbours_[before].after = after;
    if (after < entries_.size()) neighbours_[after].before = before;
  }

  // Neighbours, the earlier one first.
  void add_pair(size_t first, size_t second) {
    if (first >= entries_.size() || second >= entries_.size()) return;
    const Entries &a = entries_[first], &b = entries_[second];
    if (a.left.empty() || b.left.empty() || a.list == b.list || b.stamp - a.stamp > kLargestPairDifference) return;
    const bool image_first = a.list == List::images;
    const size_t image = image_first ? first : second, other = image_first ? second : first;
    nearest_.push({b.stamp - a.stamp, entries_[image].left.front(), entries_[other].stamp, entries_[other].left.front(),
                   image, other});
  }

  std::vector<Entries> entries_;
  std::vector<Neighbours> neighbours_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> nearest_;
};

}  // namespace

std::vector<std::pair<size_t, size_t>> pair_by_stamps(const std::vector<Timestamp>& images,
                                                      const std::vector<Timestamp>& others) {
  const std::vector<size_t> image_order = by_stamp(images), other_order = by_stamp(others);
  std::vector<Entries> entries;
  add_entries(images, image_order, List::images, entries);
  add_entries(others, other_order, List::others, entries);
  return NearestFirst(std::move(entries)).pairs();
}

}  // namespace covis::io
