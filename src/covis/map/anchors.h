// SPDX-License-Identifier: Apache-2.0
// Observations whose places were refined by the patch of one keypoint, their anchor, agree to a fraction of a pixel:
// whatever that keypoint showed, they show the same. Between two anchors of one point lies the error of a corner.
#pragma once

#include <algorithm>
#include <cstdint>

#include "covis/map/map.h"

namespace covis {

inline constexpr int kAnchorFeatureBits = 16;  // kMaxFeatures fits

// Names a keypoint by its key frame's serial and its index; never 0.
inline uint64_t anchor_at(uint32_t serial, uint32_t feature) {
  return (uint64_t{serial} + 1) << kAnchorFeatureBits | feature;
}

// The keypoint at which the chain of alignments that a feature's place comes from began: itself where it was not
// aligned. Its key frame may have been erased since.
inline uint64_t anchor_of(const KeyFrame& key_frame, uint32_t feature) {
  const AlignedVector<uint64_t>& anchor = key_frame.features->anchor;
  return anchor.empty() || anchor[feature] == 0 ? anchor_at(key_frame.serial, feature) : anchor[feature];
}

// Tells which observations of a point were aligned with one another: those with the anchor of its reference, if there
// are at least two.
class AlignedObservations {
 public:
  AlignedObservations(const Map& map, const MapPoint& point)
      : anchor_(anchor_of(map.at(point.reference), point.feature_in(point.reference))) {
    const auto& all = point.observations;
    several_ = std::count_if(all.begin(), all.end(), [&](const Observation& seen) {
                 return anchor_of(map.at(seen.key_frame), seen.feature) == anchor_;
               }) > 1;
  }
  bool contain(const KeyFrame& key_frame, uint32_t feature) const {
    return several_ && anchor_of(key_frame, feature) == anchor_;
  }

 private:
  uint64_t anchor_;
  bool several_ = false;
};

}  // namespace covis
