// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/near_features.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "covis/features/test_features.h"

namespace covis {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

Features of_depths(const std::vector<double>& depths) {
  Features features = no_features();
  for (const double depth : depths) add(features, {.x = 100, .y = 100, .depth = depth});
  finish(features);
  return features;
}

std::vector<uint32_t> near(const std::vector<double>& depths, double close_depth, int at_least) {
  std::vector<uint32_t> near{7, 7, 7};  // older content goes
  select_near_features(of_depths(depths), close_depth, at_least, near);
  return near;
}

TEST(NearFeatures, AllUpToTheBound) {
  EXPECT_THAT(near({4, 1, 0, 3, 2}, 3, 0), UnorderedElementsAre(1, 3, 4));
  EXPECT_THAT(near({4, 1, 0, 3, 2}, 0.5, 0), IsEmpty());
}

TEST(NearFeatures, TheNearestWhereFewAreClose) {
  EXPECT_THAT(near({4, 1, 0, 3, 2}, 0.5, 2), UnorderedElementsAre(1, 4));
  EXPECT_THAT(near({4, 1, 0, 3, 2}, 2, 3), UnorderedElementsAre(1, 3, 4));
  EXPECT_THAT(near({4, 1, 0, 3, 2}, 3, 2), UnorderedElementsAre(1, 3, 4)) << "more are close than are asked for";
}

TEST(NearFeatures, WithoutDepthNeverAndNeverMoreThanThereAre) {
  EXPECT_THAT(near({4, 0, 3}, 1, 100), UnorderedElementsAre(0, 2));
  EXPECT_THAT(near({0, 0}, 1, 100), IsEmpty());
}

TEST(NearFeatures, OfEqualOnesTheLowerIndices) {
  EXPECT_THAT(near({2, 2, 2, 2, 2, 2}, 1, 3), UnorderedElementsAre(0, 1, 2));
  EXPECT_THAT(near({2, 1, 2, 1, 2, 1}, 0.5, 4), UnorderedElementsAre(0, 1, 3, 5));
}

TEST(NearFeatures, TheSameDepthsInAnotherOrderAreChosenAlike) {
  Random random(1);
  std::vector<double> depths;
  for (int i = 0; i < 200; ++i) depths.push_back(random.uniform(0.5, 10));
  const auto chosen = [](const std::vector<double>& all) {
    std::vector<double> depths_of;
    for (const uint32_t i : near(all, 2, 60)) depths_of.push_back(all[i]);
    std::sort(depths_of.begin(), depths_of.end());
    return depths_of;
  };
  const std::vector<double> before = chosen(depths);
  EXPECT_EQ(before.size(), 60u);
  std::reverse(depths.begin(), depths.end());
  EXPECT_EQ(chosen(depths), before);
}

TEST(NearFeatures, NearerOnesSortFirst) {
  const Features features = of_depths({3, 1, 3, 2});
  std::vector<uint32_t> order{2, 0, 1, 3};
  std::sort(order.begin(), order.end(), NearerFeature{features});
  EXPECT_THAT(order, ElementsAre(1, 3, 0, 2));
}

}  // namespace
}  // namespace covis
