// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/drift_prior.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

constexpr int kTurn = 4, kScale = 6;  // the camera's turn about its vertical axis; the logarithm of the scale
constexpr ExpectedDrift kWay{.past = 10, .depth = 1};  // a drift of 0.02 is expected

Vector7d along(int k, double by) { return by * Vector7d::Unit(k); }

// All that matters is known to a ten thousandth but one direction.
Matrix7d known_but(int k, double sigma) {
  Vector7d sigmas = Vector7d::Constant(1e-4);
  sigmas(k) = sigma;
  return sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
}

Vector7d weighed(const Vector7d& correction, const Matrix7d& information, const ExpectedDrift& drift = kWay) {
  return weigh_against_drift(Sim3::exp(correction), information, drift).log();
}

TEST(DriftPrior, WhatThePointsKnowIsTaken) {
  Vector7d correction;
  correction << 0.03, -0.02, 0.01, 0.01, -0.02, 0.005, 0.02;
  EXPECT_LT((weighed(correction, known_but(kTurn, 1e-4)) - correction).norm(), 0.02 * correction.norm());
}

TEST(DriftPrior, WhatTheyLeaveOpenStaysAsItWas) {
  for (const int open : {0, kTurn, kScale}) {
    const Vector7d found = weighed(along(open, 0.08), known_but(open, 0.005));
    EXPECT_LT(found.norm(), 0.02) << open;
    EXPECT_GT(found(open), 0) << open;
  }
  const Matrix7d nothing = Matrix7d::Zero();
  EXPECT_LT(weighed(along(kTurn, 0.08), nothing).norm(), 1e-9);
}

TEST(DriftPrior, AGreatDriftThatIsKnownMakesMoreOfTheOthersLikely) {
  const Vector7d little = along(0, 0.02) + along(kTurn, 0.08), much = along(0, 0.5) + along(kTurn, 0.08);
  const Vector7d from_little = weighed(little, known_but(kTurn, 0.005));
  const Vector7d from_much = weighed(much, known_but(kTurn, 0.005));
  EXPECT_NEAR(from_little(0), 0.02, 0.001);
  EXPECT_LT(from_little(kTurn), 0.02);
  EXPECT_NEAR(from_much(0), 0.5, 0.005);
  EXPECT_GT(from_much(kTurn), 0.05);
}

// Twice as far past the camera, or half as far away: twice the angle is to be expected.
TEST(DriftPrior, MoreDriftIsExpectedOfALongerWay) {
  const Matrix7d information = known_but(kTurn, 0.005);
  const double near = weighed(along(kTurn, 0.01), information, {5, 1})(kTurn);
  EXPECT_GT(weighed(along(kTurn, 0.01), information, {10, 1})(kTurn), 2 * near);
  EXPECT_GT(weighed(along(kTurn, 0.01), information, {5, 0.5})(kTurn), 2 * near);
}

// The information is of a small motion after the correction: the turn goes back about the camera where the loop has it.
TEST(DriftPrior, WhatIsKnownOfALargeCorrectionStays) {
  const Sim3 correction = Sim3::exp(along(0, 1) + along(kTurn, 0.08));
  const ExpectedDrift far{.past = 500, .depth = 50};
  const Sim3 found = weigh_against_drift(correction, known_but(kTurn, 0.005), far);
  Vector7d change = (found * correction.inverse()).log();
  EXPECT_LT(change(kTurn), -0.05);
  change(kTurn) = 0;
  EXPECT_LT(change.norm(), 0.003);
}

TEST(DriftPrior, AScaleThatIsFixedStays) {
  Matrix7d information = known_but(kTurn, 0.005);
  information(kScale, kScale) = 1;
  const ExpectedDrift metric{10, 1, Scale::fixed};
  const Sim3 found = weigh_against_drift(Sim3::exp(along(0, 0.02) + along(kTurn, 0.03)), information, metric);
  EXPECT_EQ(found.scale(), 1);
  EXPECT_NEAR(found.log()(0), 0.02, 0.001);
}

TEST(DriftPrior, WithoutAWayTheCorrectionStands) {
  for (const ExpectedDrift& none : {ExpectedDrift{0, 1}, ExpectedDrift{10, 0}}) {
    const Vector7d correction = along(kTurn, 0.08);
    EXPECT_LT((weighed(correction, known_but(kTurn, 0.005), none) - correction).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace covis
