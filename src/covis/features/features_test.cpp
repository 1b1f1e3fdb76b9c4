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
  }
  return f;
}

// The keypoints of the cells under a window, in the order of the visits.
std::vector<uint16_t> under(const FeatureGrid& grid, float x, float y, float radius) {
  std::vector<uint16_t> all;
  grid.for_each_run(x, y, radius, [&](uint32_t first, uint32_t last) {
    EXPECT_LT(first, last) << "a row without keypoints is not visited";
    all.insert(all.end(), grid.indices.begin() + first, grid.indices.begin() + last);
  });
  return all;
}

class FeatureGridWindows : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(FeatureGridWindows, HoldEachKeypointInsideOnceAndNoneFarAway) {
  const auto& [count, anywhere] = GetParam();
  Random random(7);
  Features f = spread_out(random, count, anywhere);
  f.grid.build({-10, -10, 650, 490}, f.x, f.y);
  const FeatureGrid once = f.grid;
  f.grid.build({-10, -10, 650, 490}, f.x, f.y);  // a second build must replace all of the first
  EXPECT_EQ(f.grid.offsets, once.offsets);
  EXPECT_EQ(f.grid.indices, once.indices);
  EXPECT_LE(f.grid.offsets.size(), std::min(f.x.size(), FeatureGrid::kCells) + 1);
  for (int trial = 0; trial < 500; ++trial) {
    const float x = static_cast<float>(random.uniform(-60, 700)), y = static_cast<float>(random.uniform(-60, 540));
    const float radius = static_cast<float>(random.uniform(0.5, 80));
    const float cell = std::max(1 / f.grid.inv_cell_width, 1 / f.grid.inv_cell_height);
    const std::vector<uint16_t> visited = under(f.grid, x, y, radius);
    const std::set<uint16_t> found(visited.begin(), visited.end());
    EXPECT_EQ(found.size(), visited.size());
    for (uint16_t k = 0; k < f.size(); ++k) {
      const float away = std::max(std::abs(f.x[k] - x), std::abs(f.y[k] - y));
      EXPECT_TRUE(away > radius || found.contains(k));
      EXPECT_TRUE(away <= radius + 2 * cell || !found.contains(k));
    }
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
  const auto place = [&](uint16_t k) {
    const int c = std::clamp(static_cast<int>(f.x[k] / 10), 0, 63),
              r = std::clamp(static_cast<int>(f.y[k] / 10), 0, 47);
    return std::tuple(r, c, k);
  };
  std::vector<std::tuple<int, int, uint16_t>> visited;
  for (const uint16_t k : under(f.grid, 320, 240, 1000)) visited.push_back(place(k));
  EXPECT_EQ(visited.size(), f.x.size());
  EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));
}

}  // namespace
}  // namespace covis
