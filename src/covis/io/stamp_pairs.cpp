// SPDX-License-Identifier: Apache-2.0
#include "covis/io/stamp_pairs.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>

namespace covis::io {

std::vector<std::pair<size_t, size_t>> pair_by_stamps(const std::vector<Timestamp>& images,
                                                      const std::vector<Timestamp>& others) {
  struct Candidate {
    Timestamp difference;
    size_t image, other;
  };
  std::vector<size_t> order(others.size());
  for (size_t d = 0; d < order.size(); ++d) order[d] = d;
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return others[a] < others[b]; });
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < images.size(); ++i) {
    const Timestamp stamp = images[i];
    auto d = std::lower_bound(order.begin(), order.end(), stamp - kLargestPairDifference,
                              [&](size_t a, Timestamp t) { return others[a] < t; });
    for (; d != order.end() && others[*d] <= stamp + kLargestPairDifference; ++d) {
      candidates.push_back({std::abs(others[*d] - stamp), i, *d});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.difference < b.difference; });
  std::vector<uint8_t> image_used(images.size(), 0), other_used(others.size(), 0);
  std::map<size_t, size_t> other_of;
  for (const Candidate& candidate : candidates) {
    if (image_used[candidate.image] || other_used[candidate.other]) continue;
    image_used[candidate.image] = other_used[candidate.other] = 1;
    other_of[candidate.image] = candidate.other;
  }
  return {other_of.begin(), other_of.end()};
}

}  // namespace covis::io
