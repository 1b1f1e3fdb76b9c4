// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/readout_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/random.h"

namespace covis {
namespace {

constexpr double kReadout = 0.02, kRow = 20;  // seconds, pixels

// Frames that tell a readout and a row with some noise, which five frames in a row share. A frame alone tells a readout
// to some 7 ms where the camera turns by 1.
struct Teller {
  double readout = kReadout, row = 0, noise = 0.01;
  Random random{1};
  double error = 0;
  int told = 0;

  // turn: how fast the camera turns. likeness: how much a wrong row looks like a readout.
  ReadoutEquations frame(double turn = 1, double likeness = 0.5) {
    if (told++ % 5 == 0) error = noise * random.normal();
    ReadoutEquations e;
    const double varied = told % 2 ? likeness : likeness / 2;
    e.H << 2e4 * turn * turn, 1e2 * turn * varied, 1e2 * turn * varied, 1;
    e.b = e.H * Eigen::Vector2d(readout, row) + Eigen::Vector2d(e.H(0, 0) * error, 0);
    return e;
  }
};

TEST(ReadoutEstimate, TellsWhatFramesTellOnceThereAreEnough) {
  ReadoutEstimate estimate;
  Teller teller;
  for (int k = 0; k < 9; ++k) estimate.add(teller.frame());
  EXPECT_FALSE(estimate.value());
  for (int k = 0; k < 431; ++k) estimate.add(teller.frame());
  const auto value = estimate.value();
  ASSERT_TRUE(value);
  EXPECT_NEAR(value->readout, kReadout, 5 * value->sigma);
  EXPECT_NEAR(value->sigma, teller.noise / std::sqrt(88), 0.4 * teller.noise / std::sqrt(88));
  EXPECT_NEAR(value->blocks, 88, 2);
  EXPECT_NEAR(value->one_frame, 0.0074, 0.0005);
  EXPECT_LT(value->sure(), kReadout);
  estimate.restart();
  EXPECT_FALSE(estimate.value());
}

TEST(ReadoutEstimate, AWrongRowOfThePrincipalPointIsNoReadout) {
  ReadoutEstimate estimate;
  Teller teller{.readout = 0, .row = kRow, .noise = 1e-3};
  for (int k = 0; k < 200; ++k) estimate.add(teller.frame());
  const auto value = estimate.value();
  ASSERT_TRUE(value);
  EXPECT_NEAR(value->readout, 0, 3e-3);
  EXPECT_LT(std::abs(value->readout), value->by_chance());
}

TEST(ReadoutEstimate, OneBlockThatTellsNearlyAllIsNotEnough) {
  ReadoutEstimate estimate;
  Teller teller;
  for (int k = 0; k < 200; ++k) estimate.add(teller.frame(k < 5 ? 20 : 0.5));
  EXPECT_FALSE(estimate.value());
}

TEST(ReadoutEstimate, AFastTurnIsSoonEnough) {
  ReadoutEstimate estimate;
  Teller teller{.noise = 2e-3};
  for (int k = 0; k < 20; ++k) estimate.add(teller.frame(5));
  ASSERT_TRUE(estimate.value());
  EXPECT_LT(estimate.value()->sure(), kReadout);
}

TEST(ReadoutEstimate, AnErrorThatAllFramesShareIsNoReadout) {
  ReadoutEstimate estimate;
  Teller teller{.readout = 0.012, .noise = 1e-3};
  for (int k = 0; k < 3000; ++k) estimate.add(teller.frame());
  EXPECT_NEAR(estimate.value()->readout, 0.012, 0.001);
  EXPECT_GT(estimate.value()->sure(), 0.012) << "a frame alone would hardly tell it";
}

TEST(ReadoutEstimate, IsSeldomSureOfWhatIsNotThere) {
  int sure = 0;
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    ReadoutEstimate estimate;
    Teller teller{.readout = 0, .noise = 0.02, .random = Random(seed)};
    bool once = false;
    for (int k = 1; k <= 400; ++k) {
      estimate.add(teller.frame(1 + 0.5 * std::sin(0.1 * k)));
      const auto value = k % 5 == 0 ? estimate.value() : std::nullopt;
      once |= value && std::abs(value->readout) > value->by_chance();
    }
    sure += once;
  }
  EXPECT_LE(sure, 16) << "of 400 runs, whose blocks scatter six times as much as keypoints alone would";
}

TEST(ReadoutEstimate, ForgetsWhatIsLongAgo) {
  ReadoutEstimate estimate;
  Teller before{.readout = 0.01}, after{.readout = 0.03};
  for (int k = 0; k < 3000; ++k) estimate.add(before.frame());
  for (int k = 0; k < 3000; ++k) estimate.add(after.frame());
  EXPECT_NEAR(estimate.value()->readout, 0.03, 0.001);
}

TEST(ReadoutEstimate, AskingIsByStudentsT) {
  // The degrees of freedom are five more.
  for (const auto& [blocks, quantile] : {std::pair{4.0, 5.37}, {15.0, 4.18}, {294.0, 3.55}}) {
    const ReadoutEstimate::Value value{.sigma = 1, .blocks = blocks};
    EXPECT_NEAR(value.by_chance(), quantile, 0.05 * quantile) << blocks;
  }
}

}  // namespace
}  // namespace covis
