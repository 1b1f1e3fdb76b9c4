// SPDX-License-Identifier: Apache-2.0
#include "covis/features/stereo_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "covis/core/test_targets.h"
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

double row_error(const ImageU8& left, const ImageU8& right) {
  OrbExtractor from_left{OrbOptions{}}, from_right{OrbOptions{}};
  from_left.extract(left.view());
  from_right.extract(right.view());
  AlignedVector<float> u_right, depth;
  StereoMatcher matcher;
  matcher.match(from_left, from_right, kFx, kBf, u_right, depth);
  return matcher.row_error();
}

TEST(StereoMatcher, TellsHowWellTheRowsAgree) {
  const ImageU8 left = texture(400, 300, 3), right = texture(400, 300, 3, 11);
  EXPECT_LT(row_error(left, right), 0.3);
  ImageU8 lower(400, 300);
  for (int y = 0; y < 300; ++y) std::copy_n(right.row(std::max(0, y - 2)), 400, lower.row(y));
  EXPECT_GT(row_error(left, lower), 0.85) << "2 pixels";
}

// The eyes differ by gain and offset, as two cameras with an exposure of their own do.
TEST(StereoMatcher, EyesNeedNotBeEquallyBright) {
  constexpr int kShift = 11;
  const KeyPoints* points = nullptr;
  const ImageU8 left = texture(400, 300, 3);
  ImageU8 right = texture(400, 300, 3, kShift);
  const int alike = match(left, right, points).count;
  for (int y = 0; y < right.height(); ++y) {
    for (int x = 0; x < right.width(); ++x)
      right.row(y)[x] = static_cast<uint8_t>(std::clamp(0.9 * right.row(y)[x] + 20, 0.0, 255.0));
  }
  const Matched m = match(left, right, points);
  EXPECT_GT(m.count, 0.8 * alike);
  int close = 0;
  for (size_t i = 0; i < points->size(); ++i)
    close += m.depth[i] > 0 && std::abs(points->x[i] - m.u_right[i] - kShift) < 0.5f;
  EXPECT_GT(close, 0.95 * m.count);
}

// A right image of fewer or more grey levels makes differences great, up to the greatest there are.
TEST(StereoMatcher, EveryInstructionSetFindsTheSame) {
  const ImageU8 left = texture(400, 300, 3);
  for (const double contrast : {0.3, 1.0, 20.0}) {
    ImageU8 right = texture(400, 300, 3, 7);
    for (int y = 0; y < right.height(); ++y) {
      for (int x = 0; x < right.width(); ++x)
        right.row(y)[x] = static_cast<uint8_t>(std::clamp(128 + contrast * (right.row(y)[x] - 128), 0.0, 255.0));
    }
    const KeyPoints* points = nullptr;
    expect_scalar_twin([&] { return match(left, right, points).u_right; });
  }
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
