// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/window_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

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

// The definition, one pair after the other: each query to the most similar of its window, each feature to the most
// similar of its queries.
std::vector<int32_t> matches_one_by_one(const Features& f, const std::vector<WindowQuery>& queries, int max_distance) {
  std::vector<int32_t> match(queries.size(), WindowMatcher::kUnlike);
  std::map<int32_t, std::pair<int, size_t>> owner;  // by feature: distance and query
  std::vector<int> distance(queries.size(), max_distance + 1);
  for (size_t q = 0; q < queries.size(); ++q) {
    const WindowQuery& query = queries[q];
    for (size_t i = 0; i < f.x.size(); ++i) {
      const int d = hamming(*query.descriptor, f.descriptor[i]);
      const bool inside = std::abs(f.x[i] - query.u) <= query.radius && std::abs(f.y[i] - query.v) <= query.radius;
      if (!inside || f.level[i] < query.min_level || f.level[i] > query.max_level || d >= distance[q]) continue;
      distance[q] = d;
      match[q] = static_cast<int32_t>(i);
    }
    if (match[q] < 0) continue;
    const auto first = owner.emplace(match[q], std::pair(distance[q], q)).first;
    first->second = std::min(first->second, std::pair(distance[q], q));
  }
  for (size_t q = 0; q < queries.size(); ++q) {
    if (match[q] >= 0 && owner[match[q]].second != q) match[q] = WindowMatcher::kGivenAway;
  }
  return match;
}

TEST(WindowMatch, FindsWhatComparingAllFinds) {
  Random random(6);
  std::vector<Descriptor> kinds;
  for (int k = 0; k < 20; ++k) kinds.push_back(random_descriptor(random));
  const auto anywhere = [&] { return static_cast<float>(random.uniform(0, 400)); };
  WindowMatcher matcher;
  std::vector<int32_t> match;
  for (const int count : {0, 1, 700}) {
    Features f = no_features();
    for (int i = 0; i < count; ++i) {
      const Descriptor& kind = kinds[random.below(kinds.size())];
      add(f, anywhere(), anywhere(), static_cast<int>(random.below(8)), turned(kind, 20, random));
    }
    finish(f);
    std::vector<WindowQuery> queries;
    for (int q = 0; q < 300; ++q) {
      const int level = static_cast<int>(random.below(8)) - 1;  // from the least that is allowed
      queries.push_back({.u = anywhere(),
                         .v = anywhere(),
                         .radius = static_cast<float>(random.uniform(1, 90)),
                         .min_level = level,
                         .max_level = level + static_cast<int>(random.below(3)),
                         .descriptor = &kinds[random.below(kinds.size())]});
    }
    const int found = matcher.match(f, queries, {}, {}, {}, match);
    EXPECT_EQ(match, matches_one_by_one(f, queries, WindowMatchOptions{}.max_distance));
    EXPECT_EQ(found, std::count_if(match.begin(), match.end(), [](int32_t i) { return i >= 0; }));
    if (count > 100) {
      EXPECT_GT(found, 50);
      EXPECT_GT(std::count(match.begin(), match.end(), WindowMatcher::kGivenAway), 5);
    }
  }
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
