// SPDX-License-Identifier: Apache-2.0
#include "covis/synth/synth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace covis {
namespace {

uint64_t hash(const ImageU8& image) {
  uint64_t h = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) h = (h ^ image(x, y)) * 0x100000001b3ull;
  }
  return h;
}

SynthOptions small(const std::string& world, const std::string& sensor) {
  SynthOptions options;
  options.world = world;
  options.sensor = sensor;
  options.width = 320;
  options.height = 240;
  return options;
}

TEST(Synth, SameSeedSameBytesInAnyOrder) {
  auto a = Synth::create(small("room", "rgbd")), b = Synth::create(small("room", "rgbd"));
  ASSERT_TRUE(a && b);
  ImageU8 first, second, other;
  a->render(3, first, nullptr, nullptr);
  b->render(200, other, nullptr, nullptr);
  b->render(3, second, nullptr, nullptr);
  EXPECT_EQ(hash(first), hash(second));
  EXPECT_NE(hash(first), hash(other));
}

}  // namespace
}  // namespace covis
