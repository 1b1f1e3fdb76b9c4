// SPDX-License-Identifier: Apache-2.0
#include "covis/features/right_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "covis/core/random.h"

namespace covis {
namespace {

constexpr int kPairWidth = 1226, kPairHeight = 370, kOfAPair = 200;
constexpr double kRowNoise = 0.3;  // pixels

Camera rectified_pair() {
  Camera camera;
  camera.width = kPairWidth;
  camera.height = kPairHeight;
  camera.pinhole = {700, 700, 610, 185, 380};
  return camera;
}

double lower_at(const ShiftField& field, double u, double v) {
  const Pinhole c = rectified_pair().pinhole;
  return field.at((v - c.cy) / c.fy, (u - c.cx) / c.fx);
}

// Differences that the matches of one pair show: each sixth is another thing's corner.
std::vector<RowDifference> row_differences(const ShiftField& truth, Random& random) {
  std::vector<RowDifference> made;
  for (int i = 0; i < kOfAPair; ++i) {
    const double u = random.uniform(20, kPairWidth - 20), v = random.uniform(20, kPairHeight - 20);
    const double off = i % 6 == 0 ? random.uniform(-2, 2) : lower_at(truth, u, v) + kRowNoise * random.normal();
    made.push_back({static_cast<float>(u), static_cast<float>(v), static_cast<float>(off)});
  }
  return made;
}

// Columns that stay but for what matching is off by, in all of the image.
std::vector<ColumnDifference> column_differences(float right) {
  std::vector<ColumnDifference> made;
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    made.push_back({static_cast<float>(random.uniform(0, kPairWidth)),
                    static_cast<float>(random.uniform(0, kPairHeight)),
                    right + static_cast<float>(0.2 * random.normal())});
  }
  return made;
}

// Pairs whose right images are resampled as soon as a field is found: what is left of the truth then.
RightRows after_pairs(int pairs, const ShiftField& truth) {
  RightRows rows(rectified_pair());
  Random random(5);
  for (int i = 0; i < pairs; ++i) {
    ShiftField left = truth;
    for (size_t k = 0; k < ShiftField::kTerms; ++k) left.pixels[k] -= rows.field().pixels[k];
    if (const auto field = rows.add(row_differences(left, random))) {
      EXPECT_TRUE(rows.take(*field, column_differences(0)));
    }
  }
  return rows;
}

double worst_difference(const ShiftField& a, const ShiftField& b) {
  double most = 0;
  for (int u = 0; u <= kPairWidth; u += 50)
    for (int v = 0; v <= kPairHeight; v += 50) most = std::max(most, std::abs(lower_at(a, u, v) - lower_at(b, u, v)));
  return most;
}

constexpr ShiftField kTurned{{-0.08, 0.28, -0.23, 6.6, -0.7, -0.3, -1.5}};

TEST(RightRows, AreFoundFromTheFirstPairsAndThenMoreExactly) {
  EXPECT_FALSE(after_pairs(4, kTurned).field().any());
  EXPECT_LT(worst_difference(after_pairs(6, kTurned).field(), kTurned), 0.4);
  EXPECT_LT(worst_difference(after_pairs(120, kTurned).field(), kTurned), 0.15);
}

TEST(RightRows, StayWhereARectificationIsRight) { EXPECT_FALSE(after_pairs(120, {}).field().any()); }

TEST(RightRows, StayWhereTheyAreOffByLittle) {
  EXPECT_FALSE(after_pairs(120, ShiftField{{0.1}}).field().any()) << "resampling would cost more than it brings";
}

TEST(RightRows, StayWhereMatchesAreOfOtherThings) {
  RightRows rows(rectified_pair());
  Random random(7);
  for (int i = 0; i < 120; ++i) {
    std::vector<RowDifference> made = row_differences({}, random);
    for (RowDifference& d : made) d.lower = static_cast<float>(random.uniform(-2, 2) + 0.5);
    EXPECT_FALSE(rows.add(made));
  }
  EXPECT_FALSE(rows.field().any());
}

// A camera that stands still shows the same corners again and again, of which there are few.
TEST(RightRows, AFewCornersSeenOftenAreFew) {
  RightRows rows(rectified_pair());
  Random random(9);
  std::vector<RowDifference> same = row_differences({}, random);
  same.resize(24);
  for (RowDifference& d : same) d.lower = static_cast<float>(0.3 * random.normal());
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(rows.add(same));
  EXPECT_FALSE(rows.field().any());
}

// Disparities stay in the mean what they were, whatever resampling does to them.
TEST(RightRows, ColumnsStay) {
  RightRows rows(rectified_pair());
  ASSERT_TRUE(rows.take(kTurned, column_differences(-0.3f)));
  for (const double x : {-0.5, 0.0, 0.5}) EXPECT_NEAR(rows.columns().at(x, 0.1), -0.3, 0.1);
  const std::vector<ColumnDifference> few = column_differences(0);
  EXPECT_FALSE(rows.take({}, std::span(few).first(20))) << "they do not say it over all of the image";
  EXPECT_EQ(rows.field(), kTurned);
}

TEST(RightRows, ResamplingTakesThemOut) {
  RightRows rows = after_pairs(120, kTurned);
  // Grey levels that rise from row to row tell where a pixel comes from.
  ImageU8 image(kPairWidth, kPairHeight);
  for (int v = 0; v < kPairHeight; ++v) std::fill_n(image.row(v), kPairWidth, static_cast<uint8_t>(v / 2));
  ImageU8 made;
  rows.resampling(rows.field()).apply(image.view(), made);
  for (const int u : {100, 600, 1100})
    for (const int v : {60, 180, 300})
      EXPECT_NEAR(made(u, v), (v + lower_at(rows.field(), u, v)) / 2, 1) << u << " " << v;
  EXPECT_EQ(rows.description().find("up to "), 0u);
}

}  // namespace
}  // namespace covis
