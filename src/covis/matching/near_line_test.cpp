// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/near_line.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"

namespace covis {
namespace {

TEST(NearLine, FindsByEveryInstructionSetWhatAPlainSearchFinds) {
  Random random(78);
  for (const size_t count : {0u, 1u, 15u, 16u, 17u, 1000u}) {
    LinePoints points(count);
    for (size_t k = 0; k < count; ++k)
      points.set(k, static_cast<float>(random.uniform(0, 640)), static_cast<float>(random.uniform(0, 480)),
                 static_cast<float>(random.uniform(0, 400)));
    const double angle = random.uniform(0, 3);
    const std::array<float, 3> line{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)),
                                    static_cast<float>(-320 * std::cos(angle) - 240 * std::sin(angle))};
    std::vector<uint32_t> expected;
    for (uint32_t k = 0; k < count; ++k) {
      const float residual = line[0] * points.x()[k] + line[1] * points.y()[k] + line[2];
      if (residual * residual <= points.bound()[k]) expected.push_back(k);
    }
    for_each_target([&] {
      std::vector<uint32_t> found(points.size());
      found.resize(near_line(line, points, found.data()));
      EXPECT_EQ(found, expected);
    });
  }
}

}  // namespace
}  // namespace covis
