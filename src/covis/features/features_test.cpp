// SPDX-License-Identifier: Apache-2.0
#include "covis/features/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "covis/core/random.h"

namespace covis {
namespace {

TEST(ScalePyramid, PredictsTheCeilingOfTheLogarithm) {
  const ScalePyramid pyramid(8, 1.2f);
  Random random(6);
  for (int k = 0; k < 2000; ++k) {
    const double ratio = std::exp(random.uniform(-1, 2.5));
    const double exact = std::log(ratio) / std::log(1.2);
    if (std::abs(exact - std::round(exact)) < 1e-4) continue;  // rounding decides there
    EXPECT_EQ(pyramid.predict_level(static_cast<float>(ratio), 1),
              std::clamp(static_cast<int>(std::ceil(exact)), 0, 7));
  }
}

// Keypoints anywhere in the image, or on a small spot of it and its corners.
Features spread_out(Random& random, int count, bool anywhere) {
  Features f;
  for (int i = 0; i < count; ++i) {
    const bool corner = !anywhere && i % 3 == 0;
    f.x.push_back(corner ? 640 * static_cast<float>(i % 2)
                         : static_cast<float>(random.uniform(anywhere ? -10 : 200, anywhere ? 650 : 230)));
    f.y.push_back(corner ? 480 * static_cast<float>(i % 4 / 2)
                         : static_cast<float>(random.uniform(anywhere ? -10 : 100, anywhere ? 490 : 110)));
    f.level.push_back(static_cast<uint8_t>(random.below(8)));
  }
  return f;
}

class FeatureGridWindows : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(FeatureGridWindows, FindWhatBruteForceFinds) {
  const auto& [count, anywhere] = GetParam();
  Random random(7);
  Features f = spread_out(random, count, anywhere);
  f.grid.build({-10, -10, 650, 490}, f.x, f.y);
  const FeatureGrid once = f.grid;
  f.grid.build({-10, -10, 650, 490}, f.x, f.y);  // the former contents are gone
  EXPECT_EQ(f.grid.offsets, once.offsets);
  EXPECT_EQ(f.grid.indices, once.indices);
  EXPECT_LE(f.grid.offsets.size(), std::min(f.x.size(), FeatureGrid::kCells) + 1);
  for (int trial = 0; trial < 500; ++trial) {
    const float x = static_cast<float>(random.uniform(-60, 700)), y = static_cast<float>(random.uniform(-60, 540));
    const float radius = static_cast<float>(random.uniform(0.5, 80));
    const int low = static_cast<int>(random.below(8)), high = low + static_cast<int>(random.below(4));
    std::set<int> found, expected;
    f.for_each_in_window(x, y, radius, low, high, [&](int i) { EXPECT_TRUE(found.insert(i).second); });
    for (int i = 0; i < f.size(); ++i) {
      const auto k = static_cast<size_t>(i);
      if (f.level[k] >= low && f.level[k] <= high && std::abs(f.x[k] - x) <= radius && std::abs(f.y[k] - y) <= radius)
        expected.insert(i);
    }
    EXPECT_EQ(found, expected);
  }
}

// From none to more than there are cells.
INSTANTIATE_TEST_SUITE_P(Features, FeatureGridWindows,
                         testing::Combine(testing::Values(0, 1, 800, 9000), testing::Bool()));

// Cells by rows, keypoints of a cell as they come: matches that tie are decided by it.
TEST(FeatureGrid, WindowsVisitInAFixedOrder) {
  Random random(8);
  Features f = spread_out(random, 2000, true);
  const ImageBounds bounds{0, 0, 640, 480};  // some lie outside, and stand in the cells at the border
  f.grid.build(bounds, f.x, f.y);
  const auto place = [&](int i) {
    const auto k = static_cast<size_t>(i);
    const int c = std::clamp(static_cast<int>(f.x[k] / 10), 0, 63),
              r = std::clamp(static_cast<int>(f.y[k] / 10), 0, 47);
    return std::tuple(r, c, i);
  };
  std::vector<std::tuple<int, int, int>> visited;
  f.for_each_in_window(320, 240, 1000, 0, 7, [&](int i) { visited.push_back(place(i)); });
  EXPECT_EQ(visited.size(), f.x.size());
  EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));
}

}  // namespace
}  // namespace covis
