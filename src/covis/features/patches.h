// SPDX-License-Identifier: Apache-2.0
// Squares of grey levels around keypoints, cut from the pyramid levels they were found on, in which the place of a
// match is refined (matching/patch_alignment.h). A frame has one for every keypoint; so have new key frames, and older
// ones keep those of the points whose reference they are for a while.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "covis/core/aligned.h"

namespace covis {

struct Patch {
  static constexpr int kSide = 12;            // pixels of its level
  Eigen::Vector2f origin;                     // centre of its first pixel, distorted pixels of the image
  std::array<uint8_t, kSide * kSide> grey{};  // row by row
};

struct Patches {
  std::vector<Eigen::Vector2f> stretch;  // by level: image pixels for a pixel of the level
  AlignedVector<Patch> at;               // one for each feature; if `features` is not empty, for each it lists
  std::vector<uint16_t> features;        // sorted

  // Null: it has none.
  const Patch* find(size_t feature) const {
    if (features.empty()) return feature < at.size() ? &at[feature] : nullptr;
    const auto found = std::lower_bound(features.begin(), features.end(), feature);
    return found != features.end() && *found == feature ? &at[static_cast<size_t>(found - features.begin())] : nullptr;
  }
  size_t bytes() const {
    return at.size() * sizeof(Patch) + features.size() * sizeof(uint16_t) + stretch.size() * sizeof(Eigen::Vector2f);
  }
};

// These where nobody else holds them, else new ones; their content is to be overwritten. (Copying the shared pointer
// synchronises with the release by its last other owner, as in FeaturesRing.)
inline std::shared_ptr<Patches> held_alone(std::shared_ptr<Patches> patches) {
  const std::shared_ptr<Patches> copy = patches;
  return copy.use_count() == 2 ? patches : std::make_shared<Patches>();
}

}  // namespace covis
