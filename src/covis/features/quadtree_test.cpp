// SPDX-License-Identifier: Apache-2.0
#include "covis/features/quadtree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "covis/core/random.h"

namespace covis {
namespace {

std::vector<Corner> random_corners(Random& random, int count, int width, int height) {
  std::set<std::pair<int, int>> places;
  std::vector<Corner> corners;
  while (static_cast<int>(corners.size()) < count) {
    const int x = static_cast<int>(random.below(static_cast<uint32_t>(width))),
              y = static_cast<int>(random.below(static_cast<uint32_t>(height)));
    if (places.emplace(x, y).second)
      corners.push_back(
          {static_cast<int16_t>(x), static_cast<int16_t>(y), static_cast<uint8_t>(1 + random.below(255))});
  }
  return corners;
}

using Places = std::set<std::tuple<int, int, int>>;
Places places(const std::vector<Corner>& corners) {
  Places set;
  for (const Corner& c : corners) set.emplace(c.x, c.y, c.score);
  return set;
}

TEST(Quadtree, PropertiesHold) {
  Random random(4);
  Quadtree tree;
  std::vector<Corner> kept, again;
  for (int trial = 0; trial < 200; ++trial) {
    const int width = 40 + static_cast<int>(random.below(600)), height = 40 + static_cast<int>(random.below(400));
    const int count = static_cast<int>(random.below(900)), budget = static_cast<int>(random.below(300)) + 1;
    std::vector<Corner> corners = random_corners(random, std::min(count, width * height / 4), width, height);
    tree.distribute(corners, 0, 0, width, height, budget, kept);
    EXPECT_LE(static_cast<int>(kept.size()), budget + 3);
    EXPECT_GE(static_cast<int>(kept.size()),
              std::min(budget, static_cast<int>(corners.size())));  // the wanted number is reached
    const Places input = places(corners), output = places(kept);
    EXPECT_EQ(output.size(), kept.size());
    EXPECT_TRUE(std::includes(input.begin(), input.end(), output.begin(), output.end()));
    for (size_t k = corners.size(); k > 1; --k)
      std::swap(corners[k - 1], corners[random.below(static_cast<uint32_t>(k))]);
    tree.distribute(corners, 0, 0, width, height, budget, again);
    EXPECT_EQ(places(again), output);
  }
}

TEST(Quadtree, AFlatImageHasNoMoreRootsThanAreWanted) {
  Random random(5);
  Quadtree tree;
  std::vector<Corner> kept;
  tree.distribute(random_corners(random, 2000, 1200, 12), 0, 0, 1200, 12, 20, kept);
  EXPECT_GE(kept.size(), 20u);
  EXPECT_LE(kept.size(), 23u);
}

TEST(Quadtree, ClusterEmptyAndBestOfANode) {
  Random random(5);
  Quadtree tree;
  std::vector<Corner> kept;
  tree.distribute({}, 0, 0, 640, 480, 100, kept);
  EXPECT_TRUE(kept.empty());
  std::vector<Corner> cluster = random_corners(random, 200, 20, 20);
  tree.distribute(cluster, 0, 0, 640, 480, 50, kept);
  EXPECT_GE(kept.size(), 50u);
  EXPECT_LE(kept.size(), 53u);
  tree.distribute(cluster, 0, 0, 640, 480, 1, kept);
  ASSERT_EQ(kept.size(), 1u);
  for (const Corner& c : cluster) EXPECT_GE(kept[0].score, c.score);
  tree.distribute(cluster, 0, 0, 20, 300, 20, kept);  // higher than wide
  EXPECT_GE(kept.size(), 20u);
}

}  // namespace
}  // namespace covis
