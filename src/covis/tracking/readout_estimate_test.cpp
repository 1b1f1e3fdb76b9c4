// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/readout_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/random.h"

namespace covis {
namespace {

constexpr double kReadout = 0.02, kRow = 4;  // seconds, pixels

// Frames that tell a readout and a row with some noise, which ten frames in a row share.
struct Teller {
  double readout = kReadout, row = 0, noise = 1e-3;
  Random random{1};
  double error = 0;
  int told = 0;

  // turn: how fast the camera turns. likeness: how much a wrong row looks like a readout.
  ReadoutEquations frame(double turn = 1, double likeness = 0.5) {
    if (told++ % 10 == 0) error = noise * random.normal();
    ReadoutEquations e;
    const double varied = told % 2 ? likeness : likeness / 2;
    e.H << 1e4 * turn * turn, 1e2 * turn * varied, 1e2 * turn * varied, 1;
    e.b = e.H * Eigen::Vector2d(readout, row) + Eigen::Vector2d(1e4 * turn * turn * error, 0);
    return e;
  }
};

TEST(ReadoutEstimate, TellsWhatFramesTellOnceThereAreEnough) {
  ReadoutEstimate estimate;
  Teller teller;
  for (int k = 0; k < 39; ++k) estimate.add(teller.frame());
  EXPECT_FALSE(estimate.value());
  for (int k = 0; k < 400; ++k) estimate.add(teller.frame());
  const auto value = estimate.value();
  ASSERT_TRUE(value);
  EXPECT_NEAR(value->readout, kReadout, 5 * value->sigma);
  EXPECT_NEAR(value->sigma, teller.noise / std::sqrt(43), 0.4 * teller.noise / std::sqrt(43));
  EXPECT_NEAR(value->blocks, 43, 1);
  EXPECT_LT(value->sure(), kReadout);
  estimate.restart();
  EXPECT_FALSE(estimate.value());
}

TEST(ReadoutEstimate, AWrongRowOfThePrincipalPointIsNoReadout) {
  ReadoutEstimate estimate;
  Teller teller{.readout = 0, .row = kRow};
  for (int k = 0; k < 200; ++k) estimate.add(teller.frame());
  const auto value = estimate.value();
  ASSERT_TRUE(value);
  EXPECT_LT(std::abs(value->readout), value->sure());
}

TEST(ReadoutEstimate, FewBlocksThatTellNearlyAllAreNotEnough) {
  ReadoutEstimate estimate;
  Teller teller;
  for (int k = 0; k < 200; ++k) estimate.add(teller.frame(k < 20 ? 10 : 0.5));
  EXPECT_FALSE(estimate.value());
}

TEST(ReadoutEstimate, IsSeldomSureOfWhatIsNotThere) {
  int sure = 0;
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    ReadoutEstimate estimate;
    Teller teller{.readout = 0, .random = Random(seed)};
    bool once = false;
    for (int k = 1; k <= 400; ++k) {
      estimate.add(teller.frame(1 + 0.5 * std::sin(0.1 * k)));
      const auto value = k % 10 == 0 ? estimate.value() : std::nullopt;
      once |= value && std::abs(value->readout) > value->sure();
    }
    sure += once;
  }
  EXPECT_LE(sure, 6) << "of 400 runs, asked after every block";
}

TEST(ReadoutEstimate, ForgetsWhatIsLongAgo) {
  ReadoutEstimate estimate;
  Teller before{.readout = 0.01}, after{.readout = 0.03};
  for (int k = 0; k < 3000; ++k) estimate.add(before.frame());
  for (int k = 0; k < 3000; ++k) estimate.add(after.frame());
  EXPECT_NEAR(estimate.value()->readout, 0.03, 0.001);
}

TEST(ReadoutEstimate, AskingIsByStudentsT) {
  for (const auto& [blocks, quantile] :
       {std::pair{4.0, 18.7}, {6.0, 8.31}, {10.0, 5.37}, {21.0, 4.18}, {300.0, 3.55}}) {
    const ReadoutEstimate::Value value{.sigma = 1, .blocks = blocks};
    EXPECT_NEAR(value.sure(), quantile, 0.05 * quantile) << blocks;
  }
}

}  // namespace
}  // namespace covis
