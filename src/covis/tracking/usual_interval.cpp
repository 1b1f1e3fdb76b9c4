// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/usual_interval.h"

#include <algorithm>
#include <cmath>

namespace covis {

// An interval that is short in a burst and the long one beside it take two usual ones together. Where frames were left
// out pairs take longer, so that one of the shorter pairs is taken for usual.
bool UsualInterval::is_burst(Timestamp elapsed) {
  constexpr double kMuchLess = 0.6;
  constexpr size_t kKnown = 3;  // pairs
  const size_t known = std::min(count_, last_.size());
  std::array<Timestamp, 8> pairs{};
  size_t n = 0;
  for (size_t k = 2; k <= known; ++k)
    pairs[n++] = last_[(count_ - k) % last_.size()] + last_[(count_ - k + 1) % last_.size()];
  const auto usual = pairs.begin() + static_cast<ptrdiff_t>(n / 3);
  std::nth_element(pairs.begin(), usual, pairs.begin() + static_cast<ptrdiff_t>(n));
  const Timestamp interval = std::abs(elapsed);
  last_[count_++ % last_.size()] = interval;
  return n >= kKnown && static_cast<double>(interval) < kMuchLess / 2 * static_cast<double>(*usual);
}

}  // namespace covis
