// SPDX-License-Identifier: Apache-2.0
// For the tests of optimization: random similarities.
#pragma once

#include "covis/core/random.h"
#include "covis/geometry/sim3.h"

namespace covis {

inline Sim3 random_sim3(Random& random, double distance, double angle, double log_scale) {
  Vector7d xi;
  for (int k = 0; k < 3; ++k) {
    xi(k) = random.uniform(-distance, distance);
    xi(k + 3) = random.uniform(-angle, angle);
  }
  xi(6) = random.uniform(-log_scale, log_scale);
  return Sim3::exp(xi);
}

}  // namespace covis
