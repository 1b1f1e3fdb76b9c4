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

Pinhole camera() { return {.fx = kFx, .fy = kFx, .cx = 200, .cy = 150, .bf = kBf}; }

Matched match(const ImageU8& left, const ImageU8& right, const KeyPoints*& points, const Pinhole& of = camera()) {
  static OrbExtractor from_left{OrbOptions{}}, from_right{OrbOptions{}};
  points = &from_left.extract(left.view());
  from_right.extract(right.view());
  Matched matched;
  StereoMatcher().match(from_left, from_right, of, matched.u_right, matched.depth);
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

// The right image shows everything a pixel and a half too far right.
TEST(StereoMatcher, TakesOutWhatRectificationLeft) {
  constexpr int kShift = 11;
  const KeyPoints* points = nullptr;
  const ImageU8 left = texture(400, 300, 3), right = texture(400, 300, 3, kShift);
  const Matched plain = match(left, right, points);
  Pinhole off = camera();
  off.right_columns = {{1.5}};
  const Matched taken_out = match(left, right, points, off);
  ASSERT_EQ(taken_out.count, plain.count);
  for (size_t i = 0; i < points->size(); ++i) {
    EXPECT_EQ(taken_out.depth[i] > 0, plain.depth[i] > 0);
    if (!(plain.depth[i] > 0)) continue;
    EXPECT_NEAR(taken_out.u_right[i], plain.u_right[i] - 1.5f, 1e-3);
    EXPECT_NEAR(taken_out.depth[i], kBf / static_cast<double>(points->x[i] - taken_out.u_right[i]), 1e-3);
  }
  // Far things seem to lie behind infinity, and do not.
  const Matched far = match(left, texture(400, 300, 3, -1), points, off);
  EXPECT_GT(far.count, 0.8 * plain.count);
  EXPECT_LT(match(left, texture(400, 300, 3, -1), points).count, 0.2 * plain.count);
}

TEST(StereoMatcher, TellsHowFarRowsAreOff) {
  const ImageU8 left = texture(400, 300, 3), right = texture(400, 300, 3, 11);
  ImageU8 lower(400, 300);
  for (int y = 0; y < 300; ++y) std::copy_n(right.row(std::max(0, y - 1)), 400, lower.row(y));
  OrbExtractor from_left{OrbOptions{}}, from_right{OrbOptions{}};
  from_left.extract(left.view());
  from_right.extract(lower.view());
  AlignedVector<float> u_right, depth;
  StereoMatcher matcher;
  matcher.match(from_left, from_right, camera(), u_right, depth);
  ASSERT_GT(matcher.row_differences().size(), 50u);
  std::vector<float> sizes;
  for (const RowDifference& d : matcher.row_differences()) sizes.push_back(d.lower);
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2), sizes.end());
  EXPECT_NEAR(sizes[sizes.size() / 2], 1, 0.1);
}

double row_error(const ImageU8& left, const ImageU8& right) {
  OrbExtractor from_left{OrbOptions{}}, from_right{OrbOptions{}};
  from_left.extract(left.view());
  from_right.extract(right.view());
  AlignedVector<float> u_right, depth;
  StereoMatcher matcher;
  matcher.match(from_left, from_right, camera(), u_right, depth);
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
