// SPDX-License-Identifier: Apache-2.0
// Follows the noise of a depth sensor whose noise was not given: each local adjustment gives a factor, of which the
// model takes less and less.
#pragma once

#include <optional>

#include "covis/map/shared_map.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

class DepthNoiseTracker {
 public:
  // Changes the noise of the map's camera by what an adjusted problem says of it, from what it is now.
  void learn(SharedMap& map, const BundleProblem& problem);

 private:
  double scale_ = 1;   // the map's noise, as a factor on a Kinect's
  double logged_ = 1;  // the scale that was last logged
  int problems_ = 0;
  std::optional<DepthNoise> left_;  // the map's noise as it was left
};

}  // namespace covis
