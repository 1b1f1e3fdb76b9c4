// SPDX-License-Identifier: Apache-2.0
#include "covis/features/stereo_matcher.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/features/test_images.h"

namespace covis {
namespace {

struct Matched {
  AlignedVector<float> u_right, depth;
  int count = 0;
};

constexpr double kFx = 500, kBf = 50;

Matched match(const ImageU8& left, const ImageU8& right, const KeyPoints*& points) {
  static OrbExtractor from_left{OrbOptions{}}, from_right{OrbOptions{}};
  points = &from_left.extract(left.view());
  from_right.extract(right.view());
  Matched matched;
  StereoMatcher().match(from_left, from_right, kFx, kBf, matched.u_right, matched.depth);
  for (const float d : matched.depth) matched.count += d > 0;
  return matched;
}

TEST(StereoMatcher, ColumnAndDepthBelongTogether) {
  constexpr int kShift = 11;
  const KeyPoints* points = nullptr;
  const Matched m = match(texture(400, 300, 3), texture(400, 300, 3, kShift), points);
  ASSERT_EQ(m.u_right.size(), points->size());
  EXPECT_GT(m.count, 100);
  int right = 0;
  for (size_t i = 0; i < points->size(); ++i) {
    EXPECT_EQ(m.depth[i] > 0, m.u_right[i] >= 0);
    if (!(m.depth[i] > 0)) continue;
    const float disparity = points->x[i] - m.u_right[i];
    EXPECT_NEAR(m.depth[i], kBf / static_cast<double>(disparity), 1e-3);
    right += std::abs(disparity - kShift) < 1;
  }
  EXPECT_GT(right, 0.95 * m.count);
}

TEST(StereoMatcher, ImagesOfDifferentPlacesDoNotMatch) {
  const KeyPoints* points = nullptr;
  const Matched same = match(texture(400, 300, 3), texture(400, 300, 3, 8), points);
  const Matched other = match(texture(400, 300, 3), texture(400, 300, 77), points);
  EXPECT_LT(5 * other.count, same.count);
}

TEST(StereoMatcher, AnImageWithoutKeypointsHasNoMatches) {
  ImageU8 grey(400, 300);
  for (int y = 0; y < 300; ++y) std::fill_n(grey.row(y), 400, uint8_t{128});
  const KeyPoints* points = nullptr;
  EXPECT_EQ(match(texture(400, 300, 3), grey, points).count, 0);
  EXPECT_EQ(match(grey, texture(400, 300, 3), points).count, 0);
}

}  // namespace
}  // namespace covis
