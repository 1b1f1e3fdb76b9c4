// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/near_features.h"

#include <algorithm>

namespace covis {

void select_near_features(const Features& features, double close_depth, int at_least, std::vector<uint32_t>& near) {
  near.clear();
  size_t close_count = 0;
  for (uint32_t i = 0; i < static_cast<uint32_t>(features.size()); ++i) {
    if (!(features.depth[i] > 0)) continue;
    near.push_back(i);
    close_count += features.depth[i] <= close_depth;
  }
  const auto wanted = std::max(close_count, static_cast<size_t>(at_least));
  if (wanted >= near.size()) return;
  std::nth_element(near.begin(), near.begin() + static_cast<ptrdiff_t>(wanted), near.end(), NearerFeature{features});
  near.resize(wanted);
}

}  // namespace covis
