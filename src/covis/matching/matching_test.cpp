// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "covis/core/random.h"
#include "covis/features/test_features.h"
#include "covis/features/test_targets.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/epipolar_match.h"
#include "covis/matching/near_line.h"
#include "covis/matching/nearest_row.h"
#include "covis/matching/window_match.h"

namespace covis {
namespace {

const Pinhole kCamera{500, 500, 320, 240, 40};

// The same descriptor with `bits` of its bits turned.
Descriptor turned(Descriptor d, int bits, Random& random) {
  std::vector<uint32_t> order(256);
  for (uint32_t i = 0; i < 256; ++i) order[i] = i;
  for (uint32_t i = 0; i < static_cast<uint32_t>(bits); ++i) {
    std::swap(order[i], order[i + random.below(256 - i)]);
    d.bits[order[i] / 64] ^= uint64_t{1} << (order[i] % 64);
  }
  return d;
}

void add(Features& f, float x, float y, int level, const Descriptor& d) {
  add(f, {.x = x, .y = y, .level = level, .descriptor = d});
}

// By the scalar twin and by every instruction set: what a plain search finds, ties and padding among it.
TEST(NearestRow, FindsTheTwoNearestAndTheNearestOfEachColumn) {
  Random random(77);
  for (const size_t count : {0u, 1u, 2u, 7u, 8u, 9u, 100u, 1003u}) {
    Features f = no_features();
    for (size_t j = 0; j < count; ++j) {
      // Few different ones, so that there are ties.
      add(f, 1, 1, 0, {{random.below(4), j % 3 ? 0 : ~uint64_t{0}, random.below(3), random.below(2)}});
    }
    std::vector<uint8_t> use(count);
    for (size_t j = 0; j < count; ++j) use[j] = count < 3 || random.below(5) != 0;
    const DescriptorPlanes planes(f, use);
    std::vector<Descriptor> queries;
    for (int i = 0; i < 20; ++i) queries.push_back({{random.below(4), random.below(2), random.below(3), 0}});
    std::vector<uint64_t> expected_column(planes.size(), kFarthest);
    std::vector<NearestTwo> expected;
    for (uint32_t i = 0; i < queries.size(); ++i) {
      std::vector<uint64_t> keys;
      for (uint32_t j = 0; j < planes.size(); ++j) {
        const int distance = hamming(queries[i], f.descriptor[static_cast<size_t>(planes.feature(j))]);
        keys.push_back(near_key(distance, j));
        expected_column[j] = std::min(expected_column[j], near_key(distance, i));
      }
      std::sort(keys.begin(), keys.end());
      keys.resize(std::max<size_t>(keys.size(), 2), kFarthest);
      expected.push_back({keys[0], keys[1]});
    }
    for_each_target([&] {
      AlignedVector<uint64_t> column(planes.padded_size(), kFarthest);
      for (uint32_t i = 0; i < queries.size(); ++i) {
        const NearestTwo two = nearest_row(queries[i], i, planes, column.data());
        EXPECT_EQ(two.best, expected[i].best);
        EXPECT_EQ(two.second, expected[i].second);
      }
      EXPECT_TRUE(std::equal(expected_column.begin(), expected_column.end(), column.begin()));
    });
  }
}

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
      std::vector<uint32_t> found(points.padded() + LinePoints::kStep);
      found.resize(near_line(line, points, found.data()));
      EXPECT_EQ(found, expected);
    });
  }
}

TEST(WindowMatch, FindsTheMostSimilarInTheWindowOnly) {
  Random random(1);
  const Descriptor wanted = random_descriptor(random);
  Features f = no_features();
  add(f, 100, 100, 2, turned(wanted, 30, random));  // inside, similar
  add(f, 105, 100, 2, turned(wanted, 10, random));  // inside, more similar
  add(f, 140, 100, 2, wanted);                      // the same, but outside
  add(f, 101, 100, 5, wanted);                      // the same, but of another level
  finish(f);
  const std::vector<WindowQuery> queries{{100, 100, -1, 10, 1, 3, &wanted}};
  WindowMatcher matcher;
  std::vector<int32_t> match;
  EXPECT_EQ(matcher.match(f, queries, {}, {}, match), 1);
  EXPECT_EQ(match[0], 1);
  // Taken features are passed over.
  EXPECT_EQ(matcher.match(f, queries, std::vector<uint8_t>{0, 1, 0, 0}, {}, match), 1);
  EXPECT_EQ(match[0], 0);
  // Too different.
  EXPECT_EQ(matcher.match(f, queries, {}, {.max_distance = 9}, match), 0);
  EXPECT_EQ(match[0], -1);
}

TEST(WindowMatch, RatioIsAskedWithinOneLevelOnly) {
  Random random(2);
  const Descriptor wanted = random_descriptor(random);
  for (const int second_level : {2, 3}) {
    Features f = no_features();
    add(f, 100, 100, 2, turned(wanted, 20, random));
    add(f, 103, 100, second_level, turned(wanted, 22, random));
    finish(f);
    const std::vector<WindowQuery> queries{{100, 100, -1, 10, 1, 3, &wanted}};
    WindowMatcher matcher;
    std::vector<int32_t> match;
    EXPECT_EQ(matcher.match(f, queries, {}, {.ratio = 0.8f}, match), second_level == 2 ? 0 : 1);
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
  const WindowQuery qa{100, 100, -1, 10, 0, 0, &a}, qb{100, 100, -1, 10, 0, 0, &b};
  EXPECT_EQ(matcher.match(f, std::vector{qa, qb}, {}, {}, match), 1);
  EXPECT_EQ(match, (std::vector<int32_t>{0, -1}));
  EXPECT_EQ(matcher.match(f, std::vector{qb, qa}, {}, {}, match), 1);
  EXPECT_EQ(match, (std::vector<int32_t>{-1, 0}));
}

TEST(WindowMatch, ChecksTheRightColumnAndChiSquare) {
  Random random(4);
  const Descriptor wanted = random_descriptor(random);
  Features f = no_features();
  add(f, {.x = 100, .y = 100, .descriptor = wanted, .u_right = 80});
  finish(f);
  WindowMatcher matcher;
  std::vector<int32_t> match;
  const auto matches = [&](float u, float u_right, float chi2) {
    const std::vector<WindowQuery> queries{{u, 100, u_right, 10, 0, 0, &wanted}};
    return matcher.match(f, queries, {}, {.max_chi2_mono = chi2, .max_chi2_stereo = chi2}, match);
  };
  EXPECT_EQ(matches(100, 85, 0), 1);
  EXPECT_EQ(matches(100, 95, 0), 0);  // off by more than the radius
  EXPECT_EQ(matches(100, -1, 0), 1);  // not asked
  EXPECT_EQ(matches(102, -1, 5), 1);  // 4 <= 5
  EXPECT_EQ(matches(103, -1, 5), 0);  // 9 > 5
  EXPECT_EQ(matches(102, 82, 5), 0);  // 4 + 4 > 5
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

TEST(DescriptorMatch, FindsAPermutationAndSkipsWhatIsAmbiguousOrUnused) {
  Random random(6);
  Features a = no_features(), b = no_features();
  constexpr int kCount = 200;
  for (int i = 0; i < kCount; ++i) add(a, 10, 10, 0, random_descriptor(random));
  for (int i = 0; i < kCount; ++i) {
    add(b, 10, 10, 0, turned(a.descriptor[static_cast<size_t>((i * 7) % kCount)], 15, random));
  }
  b.descriptor[20] = b.descriptor[21];  // two of a kind: neither the lost original nor the doubled one may match
  std::vector<uint8_t> use_b(kCount, 1);
  use_b[50] = 0;
  const auto matches = match_descriptors(a, {}, b, use_b, {});
  EXPECT_EQ(matches.size(), static_cast<size_t>(kCount - 3));
  for (const FeatureMatch& m : matches) EXPECT_EQ(m.a, (m.b * 7) % kCount);
}

TEST(EpipolarMatch, TakesTheOneNearTheLine) {
  Random random(7);
  const SE3 T_ba(so3_exp({0.02, -0.05, 0.01}), Eigen::Vector3d(-0.4, 0.05, 0.02));
  Features a = no_features(), b = no_features();
  int expected = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p_a(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(3, 8));
    const Eigen::Vector2d at_a = kCamera.project(p_a), at_b = kCamera.project(T_ba * p_a);
    const Descriptor d = random_descriptor(random);
    const bool off = i % 3 == 0;  // moved away from its line
    add(a, static_cast<float>(at_a.x()), static_cast<float>(at_a.y()), 0, d);
    add(b, static_cast<float>(at_b.x()), static_cast<float>(at_b.y()) + (off ? 8.0f : 0.0f), 0, turned(d, 20, random));
    if (!off) ++expected;
  }
  const auto matches = match_epipolar(kCamera, a, {}, b, {}, T_ba, {});
  EXPECT_EQ(static_cast<int>(matches.size()), expected);
  for (const FeatureMatch& m : matches) {
    EXPECT_EQ(m.a, m.b);
    EXPECT_NE(m.a % 3, 0);
  }
}

TEST(EpipolarMatch, StaysAwayFromTheEpipole) {
  Random random(8);
  const SE3 T_ba(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 1));  // straight ahead: the epipole is the centre
  Features a = no_features(), b = no_features();
  const Descriptor d = random_descriptor(random);
  add(a, 321, 240, 0, d);
  add(b, 322, 240, 0, d);
  EXPECT_TRUE(match_epipolar(kCamera, a, {}, b, {}, T_ba, {}).empty());
  EXPECT_EQ(match_epipolar(kCamera, a, {}, b, {}, T_ba, {.epipole_margin = 1}).size(), 1u);
}

}  // namespace
}  // namespace covis
