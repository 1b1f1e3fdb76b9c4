// SPDX-License-Identifier: Apache-2.0
// The features of a frame whose depth is good enough to make points of: the near ones (ORB-SLAM2, T-RO 2017, III-A).
#pragma once

#include <cstdint>
#include <vector>

#include "covis/features/features.h"

namespace covis {

// Orders features by depth; of equal ones the lower index comes first.
struct NearerFeature {
  const Features& features;
  bool operator()(uint32_t a, uint32_t b) const {
    return features.depth[a] != features.depth[b] ? features.depth[a] < features.depth[b] : a < b;
  }
};

// Fills `near` with the features of depth up to `close_depth` (metres), or with the `at_least` nearest ones when those
// are fewer. In no particular order.
void select_near_features(const Features& features, double close_depth, int at_least, std::vector<uint32_t>& near);

}  // namespace covis
