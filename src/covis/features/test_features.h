// SPDX-License-Identifier: Apache-2.0
// For tests: features made by hand, with every array filled as the front end fills them for a camera
// without distortion.
#pragma once

#include <memory>

#include "covis/core/random.h"
#include "covis/features/features.h"

namespace covis {

inline Descriptor random_descriptor(Random& random) {
  return {{random.next(), random.next(), random.next(), random.next()}};
}

// Without keypoints.
inline Features no_features() {
  Features f;
  f.pyramid = std::make_shared<ScalePyramid>(8, 1.2f);
  return f;
}

struct TestKeyPoint {
  double x = 0, y = 0;
  int level = 0;
  Descriptor descriptor{};
  double angle = 0;
  double depth = 0, u_right = -1;  // either may be given; the other follows
};

// bf: pixels of disparity at a depth of one metre (Pinhole::bf).
inline void add(Features& f, const TestKeyPoint& k, double bf = 40) {
  f.x.push_back(static_cast<float>(k.x));
  f.y.push_back(static_cast<float>(k.y));
  f.angle.push_back(static_cast<float>(k.angle));
  f.level.push_back(static_cast<uint8_t>(k.level));
  f.depth.push_back(static_cast<float>(k.depth > 0 ? k.depth : k.u_right >= 0 ? bf / (k.x - k.u_right) : 0));
  f.u_right.push_back(static_cast<float>(k.depth > 0 ? k.x - bf / k.depth : k.u_right));
  f.descriptor.push_back(k.descriptor);
}

// To be called after the last keypoint.
inline void finish(Features& f, const ImageBounds& bounds = {0, 0, 640, 480}) { f.grid.build(bounds, f.x, f.y); }

// Anywhere in an image of 640 x 480, of all levels, all of one depth (0: none).
inline FeaturesPtr random_features(Random& random, int count, double depth) {
  auto f = std::make_shared<Features>(no_features());
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0, 640), y = random.uniform(0, 480);
    const int level = static_cast<int>(random.below(8));
    add(*f, {.x = x, .y = y, .level = level, .descriptor = random_descriptor(random), .depth = depth});
  }
  finish(*f);
  return f;
}

}  // namespace covis
