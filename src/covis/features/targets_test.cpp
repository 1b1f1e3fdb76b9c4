// SPDX-License-Identifier: Apache-2.0
// The chain from image to matches by every instruction set against the scalar twins: same bits. Needs nothing but the
// core, so that tools/test_neon can run it for another processor.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "covis/core/random.h"
#include "covis/features/frontend.h"
#include "covis/features/hamming.h"
#include "covis/features/simd.h"

namespace covis {
namespace {

// Boxes of many sizes and grey levels, a little smoothed, with some noise; moved left by `shift` pixels.
ImageU8 boxes(int width, int height, int shift) {
  Random random(5);
  Image<float> plain(width, height);
  for (int y = 0; y < height; ++y) std::fill(plain.row(y), plain.row(y) + width, 128.0f);
  for (int k = 0; k < width * height / 300; ++k) {
    const int w = 3 + static_cast<int>(random.below(40)), h = 3 + static_cast<int>(random.below(40));
    const int x0 = static_cast<int>(random.below(static_cast<uint32_t>(width + 60))) - shift,
              y0 = static_cast<int>(random.below(static_cast<uint32_t>(height)));
    const auto grey = static_cast<float>(random.below(256));
    for (int y = y0; y < std::min(height, y0 + h); ++y) {
      for (int x = std::max(0, x0); x < std::min(width, x0 + w); ++x) plain(x, y) = grey;
    }
  }
  ImageU8 image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto at = [&](int dx, int dy) {
        return plain(std::clamp(x + dx, 0, width - 1), std::clamp(y + dy, 0, height - 1));
      };
      const float mean = 0.5f * at(0, 0) + 0.125f * (at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1));
      image(x, y) = static_cast<uint8_t>(std::clamp(mean + static_cast<float>(random.below(5)), 0.0f, 255.0f));
    }
  }
  return image;
}

// Everything an extraction and stereo matching make, as bytes.
std::string made_of(const Features& f) {
  std::string text;
  const auto add = [&](const auto& array) {
    text.append(reinterpret_cast<const char*>(array.data()), array.size() * sizeof(array[0]));
  };
  for (const auto* array : {&f.x, &f.y, &f.angle, &f.u_right, &f.depth}) add(*array);
  add(f.level);
  add(f.descriptor);
  add(f.grid.indices);
  return text;
}

class Targets : public ::testing::Test {
 protected:
  ~Targets() override { use_simd_target("best"); }
};

TEST_F(Targets, FeaturesAndStereoAreThoseOfTheScalarTwins) {
  for (const auto& [width, height] : {std::pair{640, 480}, {333, 251}, {70, 64}}) {
    const ImageU8 left = boxes(width, height, 0), right = boxes(width, height, 9);
    Camera camera;
    camera.width = width;
    camera.height = height;
    camera.pinhole = {500, 500, width / 2.0, height / 2.0, 50};
    const auto run = [&] {
      Frontend frontend(camera, {.features = 800}, Sensor::stereo);
      return frontend.stereo(left.view(), right.view());
    };
    ASSERT_TRUE(use_simd_target("scalar"));
    const FeaturesPtr expected = run();
    if (width == 640) {
      EXPECT_GT(expected->size(), 600);
      EXPECT_GT(std::count_if(expected->depth.begin(), expected->depth.end(), [](float d) { return d > 0; }), 150);
    }
    for (const std::string& target : simd_targets()) {
      ASSERT_TRUE(use_simd_target(target));
      EXPECT_TRUE(made_of(*run()) == made_of(*expected)) << target << ", " << width << "x" << height;
    }
  }
}

TEST_F(Targets, AreThoseOfTheProcessor) {
  const std::vector<std::string> names = simd_targets();
  EXPECT_EQ(names.back(), "scalar");
#if defined(__aarch64__)
  EXPECT_NE(std::find(names.begin(), names.end(), "neon"), names.end());
#elif defined(__x86_64__)
  EXPECT_NE(std::find(names.begin(), names.end(), "ssse3"), names.end());
#endif
}

TEST_F(Targets, HammingDistancesAreThoseOfTheScalarTwin) {
  Random random(6);
  AlignedVector<Descriptor> many(77);
  for (Descriptor& d : many) d = {{random.next(), random.next(), random.next(), random.next()}};
  for (const std::string& target : simd_targets()) {
    ASSERT_TRUE(use_simd_target(target));
    std::vector<uint16_t> row(many.size());
    hamming_row(many[3], many.data(), static_cast<int>(many.size()), row.data());
    for (size_t j = 0; j < many.size(); ++j) EXPECT_EQ(row[j], hamming(many[3], many[j])) << target;
  }
}

}  // namespace
}  // namespace covis
