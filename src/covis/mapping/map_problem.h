// SPDX-License-Identifier: Apache-2.0
// A piece of the map as a bundle adjustment problem, and its way back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "covis/map/map_edit.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

// A bundle problem, and the key frame or point of the map that each entry stands for.
struct MapProblem {
  BundleProblem problem;
  std::vector<KeyFrameId> key_frames;  // for each pose
  std::vector<MapPointId> points;      // for each point
  std::vector<uint8_t> aligned;        // for each observation: it weighs as one whose place was refined

  // Takes the points that the first `moving` of `frames` see, with all observations from any of `frames`. Key frames
  // from the `moving`th on, and roots, stay fixed.
  void gather(const Map& map, const std::vector<KeyFrameId>& frames, size_t moving);
  // Writes the result to what still exists; observations found to be outliers go. Aligned ones are left out of the fit
  // by their own bound, and go by that of keypoints: a rolling shutter, say, puts all such places farther off.
  void commit(MapEdit& map) const;
  // Only these.
  void erase_outliers(MapEdit& map) const;

 private:
  bool fits_as_keypoint(size_t observation) const;
};

}  // namespace covis
