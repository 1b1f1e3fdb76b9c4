// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>
#include <utility>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"
#include "covis/features/extractor.h"
#include "covis/features/orb.h"
#include "covis/features/test_images.h"

namespace covis {
namespace {

TEST(Simd, OrientationAndDescriptorsAreTheScalarOnes) {
  Random random(32);
  const ImageU8 image = texture(300, 200, 33);
  for (int trial = 0; trial < 500; ++trial) {
    const int x = kEdgeBorder + static_cast<int>(random.below(300 - 2 * kEdgeBorder)),
              y = kEdgeBorder + static_cast<int>(random.below(200 - 2 * kEdgeBorder));
    const uint8_t* pixel = image.row(y) + x;
    const auto angle = static_cast<float>(random.uniform(0, 2 * std::numbers::pi));
    expect_scalar_twin(
        [&] { return std::pair(orientation(pixel, image.stride()), describe(pixel, image.stride(), angle)); });
  }
}

}  // namespace
}  // namespace covis
