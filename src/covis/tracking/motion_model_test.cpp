// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/motion_model.h"

#include <gtest/gtest.h>

#include "covis/geometry/lie.h"

namespace covis {
namespace {

constexpr Timestamp kFrame = from_seconds(0.1);

class MotionModelTest : public testing::Test {
 protected:
  static double difference(const SE3& a, const SE3& b) { return (a.inverse() * b).log().norm(); }

  const SE3 T_21{so3_exp({0.02, -0.05, 0.01}), {0.1, 0.02, -0.3}};
  MotionModel motion;
};

TEST_F(MotionModelTest, NothingIsExpectedBeforeAMotionIsKnown) {
  EXPECT_FALSE(motion.predict(kFrame));
  motion.observe(T_21, kFrame);
  EXPECT_TRUE(motion.predict(kFrame));
  motion.reset();
  EXPECT_FALSE(motion.predict(kFrame));
}

TEST_F(MotionModelTest, TheCameraMovesOnAsItDid) {
  motion.observe(SE3(), kFrame);
  motion.observe(T_21, kFrame);
  EXPECT_EQ(motion.predict(kFrame)->t(), T_21.t()) << "the last motion, to the bit";
  EXPECT_EQ(motion.predict(kFrame)->R(), T_21.R());
}

TEST_F(MotionModelTest, JitterOfTheStampsChangesNothing) {
  motion.observe(T_21, kFrame);
  for (const double jitter : {0.75, 1.35}) {
    EXPECT_EQ(motion.predict(static_cast<Timestamp>(jitter * kFrame))->t(), T_21.t()) << jitter;
  }
}

TEST_F(MotionModelTest, FramesLeftOutAreMadeUpFor) {
  motion.observe(T_21, kFrame);
  EXPECT_LT(difference(*motion.predict(2 * kFrame), T_21 * T_21), 1e-9);
  EXPECT_LT(difference(*motion.predict(3 * kFrame), T_21 * T_21 * T_21), 1e-9);
}

TEST_F(MotionModelTest, HalfTheTimeIsHalfTheWay) {
  motion.observe(T_21, kFrame);
  const SE3 half = *motion.predict(kFrame / 2);
  EXPECT_LT(difference(half * half, T_21), 1e-9);
}

TEST_F(MotionModelTest, AMotionInABurstIsTakenWithTheOneBefore) {
  for (int k = 0; k < 6; ++k) motion.observe(T_21, kFrame);
  motion.observe(T_21, kFrame / 10);  // stamped nine tenths too early
  EXPECT_FALSE(motion.is_pause(2 * kFrame));
  EXPECT_LT(difference(*motion.predict(kFrame * 11 / 10), T_21 * T_21), 1e-9) << "two motions in that time";
  motion.observe(T_21, 19 * kFrame / 10);
  EXPECT_EQ(motion.predict(19 * kFrame / 10)->t(), T_21.t());
  motion.reset();
  motion.observe(T_21, kFrame / 10);
  EXPECT_FALSE(motion.predict(kFrame)) << "alone it tells no motion";
}

TEST_F(MotionModelTest, AfterAPauseTheCameraMayBeAnywhere) {
  EXPECT_FALSE(motion.is_pause(100 * kFrame)) << "nothing is known of its frames";
  motion.observe(T_21, kFrame);
  EXPECT_FALSE(motion.is_pause(5 * kFrame));
  EXPECT_TRUE(motion.is_pause(5 * kFrame + 1));
  EXPECT_TRUE(motion.predict(5 * kFrame));
  EXPECT_FALSE(motion.predict(5 * kFrame + 1));
  EXPECT_TRUE(motion.predict(kFrame)) << "asking changes nothing";
}

TEST_F(MotionModelTest, LengthsGrowWithTheMapAndTurnsDoNot) {
  motion.rescale(2);  // without a motion: nothing to rescale
  EXPECT_FALSE(motion.predict(kFrame));
  motion.observe(T_21, kFrame);
  motion.rescale(2);
  EXPECT_EQ(motion.predict(kFrame)->t(), 2 * T_21.t());
  EXPECT_EQ(motion.predict(kFrame)->R(), T_21.R());
}

TEST_F(MotionModelTest, AnotherTurnKeepsTheCentre) {
  const Eigen::Matrix3d R = so3_exp({0.1, 0.3, -0.2});
  const SE3 turned = MotionModel::turned(T_21, R);
  EXPECT_EQ(turned.R(), R);
  EXPECT_LT((turned.centre() - T_21.centre()).norm(), 1e-12);
}

}  // namespace
}  // namespace covis
