// SPDX-License-Identifier: Apache-2.0
// The chain from image to matches by every instruction set against the scalar twins: same bits. Needs nothing but the
// core, so that tools/test_neon can run it for another processor.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "covis/core/simd_targets.h"
#include "covis/core/test_targets.h"
#include "covis/features/frontend.h"
#include "covis/features/hamming.h"
#include "covis/features/test_images.h"

namespace covis {
namespace {

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

TEST(Targets, FeaturesAndStereoAreThoseOfTheScalarTwins) {
  for (const auto& [width, height] : {std::pair{640, 480}, {333, 251}, {97, 71}, {70, 64}, {41, 200}, {20, 20}}) {
    const ImageU8 left = texture(width, height, 5), right = texture(width, height, 5, 9);
    Camera camera;
    camera.width = width;
    camera.height = height;
    camera.pinhole = {500, 500, width / 2.0, height / 2.0, 50};
    const auto run = [&] {
      Frontend frontend(camera, {.features = 800}, Sensor::stereo);
      return frontend.stereo(left.view(), right.view());
    };
    expect_scalar_twin([&] { return made_of(*run()); });
    if (width == 640) {
      const FeaturesPtr features = run();
      EXPECT_GT(features->size(), 600);
      EXPECT_GT(std::count_if(features->depth.begin(), features->depth.end(), [](float d) { return d > 0; }), 150);
    }
  }
}

TEST(Targets, AreThoseOfTheProcessor) {
  const std::vector<std::string> names = simd_targets();
  EXPECT_EQ(names.back(), "scalar");
#if defined(__aarch64__)
  EXPECT_NE(std::find(names.begin(), names.end(), "neon"), names.end());
#elif defined(__x86_64__)
  EXPECT_NE(std::find(names.begin(), names.end(), "ssse3"), names.end());
#endif
}

TEST(Targets, HammingDistancesAreThoseOfTheScalarTwin) {
  Random random(6);
  AlignedVector<Descriptor> many(77);
  for (Descriptor& d : many) d = {{random.next(), random.next(), random.next(), random.next()}};
  for_each_target([&] {
    std::vector<uint16_t> row(many.size());
    hamming_row(many[3], many.data(), static_cast<int>(many.size()), row.data());
    for (size_t j = 0; j < many.size(); ++j) EXPECT_EQ(row[j], hamming(many[3], many[j]));
  });
}

}  // namespace
}  // namespace covis
