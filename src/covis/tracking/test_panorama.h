// SPDX-License-Identifier: Apache-2.0
// For tests: a world at infinity, of which every view is known.
#pragma once

#include <cmath>
#include <vector>

#include "covis/core/random.h"
#include "covis/features/small_image.h"

namespace covis {

// A sphere of soft waves of many lengths, seen from its centre: an image of it is known for every rotation.
class Panorama {
 public:
  explicit Panorama(uint64_t seed) {
    Random random(seed);
    for (int k = 0; k < 60; ++k) {
      const Eigen::Vector3d direction = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
      const double frequency = 3 * std::exp(random.uniform(0, 2.7));  // radians of phase for one of angle
      waves_.push_back({direction * frequency, random.uniform(0, 6.28), 25 / std::sqrt(frequency)});
    }
  }
  double grey(const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d at = ray.normalized();
    double sum = 128;
    for (const Wave& w : waves_) sum += w.height * std::sin(w.number.dot(at) + w.phase);
    return sum;
  }

 private:
  struct Wave {
    Eigen::Vector3d number;
    double phase, height;
  };
  std::vector<Wave> waves_;
};

}  // namespace covis
