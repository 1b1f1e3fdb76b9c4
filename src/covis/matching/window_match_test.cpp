// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/window_match.h"

#include <gtest/gtest.h>

#include "covis/matching/test_matching.h"

namespace covis {
namespace {

TEST(WindowMatch, FindsTheMostSimilarInTheWindowOnly) {
  Random random(1);
  const Descriptor wanted = random_descriptor(random);
  Features f = no_features();
  add(f, 100, 100, 2, turned(wanted, 30, random));  // inside, similar
  add(f, 105, 100, 2, turned(wanted, 10, random));  // inside, more similar
  add(f, 140, 100, 2, wanted);                      // the same, but outside
  add(f, 101, 100, 5, wanted);                      // the same, but of another level
  finish(f);
  const std::vector<WindowQuery> queries{{100, 100, 0, 10, 1, 3, &wanted}};
  WindowMatcher matcher;
  std::vector<int32_t> match;
  EXPECT_EQ(matcher.match(f, queries, {}, {}, {}, match), 1);
  EXPECT_EQ(match[0], 1);
  // Taken features are passed over.
  EXPECT_EQ(matcher.match(f, queries, std::vector<uint8_t>{0, 1, 0, 0}, {}, {}, match), 1);
  EXPECT_EQ(match[0], 0);
  // Too different.
  EXPECT_EQ(matcher.match(f, queries, {}, {}, {.max_distance = 9}, match), 0);
  EXPECT_EQ(match[0], WindowMatcher::kUnlike);
}

TEST(WindowMatch, RatioIsAskedWithinOneLevelOnly) {
  Random random(2);
  const Descriptor wanted = random_descriptor(random);
  for (const int second_level : {2, 3}) {
    Features f = no_features();
    add(f, 100, 100, 2, turned(wanted, 20, random));
    add(f, 103, 100, second_level, turned(wanted, 22, random));
    finish(f);
    const std::vector<WindowQuery> queries{{100, 100, 0, 10, 1, 3, &wanted}};
    WindowMatcher matcher;
    std::vector<int32_t> match;
    EXPECT_EQ(matcher.match(f, queries, {}, {}, {.ratio = 0.8f}, match), second_level == 2 ? 0 : 1);
  }
}

TEST(WindowMatch, AFeatureGoesToTheMoreSimilarQuery) {
  Random random(3);
  const Descriptor a = random_descriptor(random);
  const Descriptor b = turned(a, 40, random);
  Features f = no_features();
  add(f, 100, 100, 0, turned(a, 5, random));
  finish(f);
  WindowMatcher matcher;
  std::vector<int32_t> match;
  const WindowQuery qa{100, 100, 0, 10, 0, 0, &a}, qb{100, 100, 0, 10, 0, 0, &b};
  EXPECT_EQ(matcher.match(f, std::vector{qa, qb}, {}, {}, {}, match), 1);
  EXPECT_EQ(match, (std::vector<int32_t>{0, WindowMatcher::kGivenAway}));
  EXPECT_EQ(matcher.match(f, std::vector{qb, qa}, {}, {}, {}, match), 1);
  EXPECT_EQ(match, (std::vector<int32_t>{WindowMatcher::kGivenAway, 0}));
}

TEST(WindowMatch, ChecksTheDepthAndTheError) {
  Random random(4);
  const Descriptor wanted = random_descriptor(random);
  Features f = no_features();
  add(f, {.x = 100, .y = 100, .descriptor = wanted, .u_right = 80});
  finish(f);
  WindowMatcher matcher;
  std::vector<int32_t> match;
  Pinhole camera{500, 500, 320, 240, 40};
  const auto matches = [&](float u, float disparity, bool bound) {
    const std::vector<WindowQuery> queries{{u, 100, disparity, 10, 0, 0, &wanted}};
    return matcher.match(f, queries, {}, camera, {.within_bound = bound}, match);
  };
  EXPECT_EQ(matches(100, 15, false), 1);
  EXPECT_EQ(matches(100, 5, false), 0);  // off by more than the radius
  EXPECT_EQ(matches(100, 0, false), 1);  // not asked
  EXPECT_EQ(matches(102, 0, true), 1);   // 4 <= 5.99
  EXPECT_EQ(matches(103, 0, true), 0);   // 9 > 5.99
  EXPECT_EQ(matches(102, 18, true), 0);  // 4 + 4 > 7.81
  camera.depth_noise = DepthNoise::kinect();
  EXPECT_EQ(matches(100, 15, false), 0);  // a depth sensor is surer
  EXPECT_EQ(matches(101, 18, true), 1);   // but its depth alone rules no match out
  EXPECT_EQ(matches(103, 20, true), 0);
}

TEST(CheckRotation, KeepsTheBulkWhateverItsAngle) {
  Random random(5);
  for (const float common : {0.0f, 0.01f, 3.0f, 6.2f, -1.0f}) {
    std::vector<float> a, b;
    std::vector<uint8_t> keep;
    for (int k = 0; k < 100; ++k) {
      b.push_back(static_cast<float>(random.uniform(0, 6.28)));
      const bool wrong = k % 10 == 0;
      a.push_back(b.back() + common + (wrong ? 2.0f : static_cast<float>(random.uniform(-0.1, 0.1))));
      keep.push_back(1);
    }
    EXPECT_EQ(check_rotation(a, b, keep), 90);
    for (size_t k = 0; k < keep.size(); ++k) EXPECT_EQ(keep[k], k % 10 != 0);
  }
}

}  // namespace
}  // namespace covis
