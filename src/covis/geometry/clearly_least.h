// SPDX-License-Identifier: Apache-2.0
// A decision among hypotheses by how badly each fits: only where one fits clearly better than every other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

namespace covis {

// The index of the misfit that every other exceeds by this factor and by this difference; nullopt if there is none.
inline std::optional<size_t> clearly_least(std::span<const double> misfits, double factor, double difference) {
  const auto least = std::ranges::min_element(misfits);
  for (auto other = misfits.begin(); other != misfits.end(); ++other) {
    if (other != least && (*other < factor * *least || *other < *least + difference)) return std::nullopt;
  }
  if (misfits.empty()) return std::nullopt;
  return static_cast<size_t>(least - misfits.begin());
}

}  // namespace covis
