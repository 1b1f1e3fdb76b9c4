// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/place_check.h"

#include <gtest/gtest.h>

#include "covis/map/test_map.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

// Without a map that could be asked what is seen from there.

class TentativePlaceTest : public testing::Test {
 protected:
  // The frame is found x metres to the right, and is right. It sees a point 5 metres ahead.
  void find(int64_t frame, double seconds, double x, Arrival arrival = Arrival::tracked, uint32_t submap = 0) {
    TrackedFrame found = at(frame, seconds, x);
    local_map.reference.submap = submap;
    EXPECT_TRUE(place.is_right({found, local_map, {}, nullptr}, arrival));
    place.accept(found, submap);
  }
  TrackedFrame at(int64_t frame, double seconds, double x) {
    TrackedFrame found;
    found.start(features, frame, from_seconds(seconds));
    found.T_cw = pose_at(x);
    found.set_match(0, {0, 0}, {x, 0, 5}, PointSource::map);
    return found;
  }
  // Settled at x = 0 with frame 0.
  void settle() {
    place.restart_at(at(0, 0, 0), 0);
    place.accept(at(0, 0, 0), 0);
    ASSERT_FALSE(place.tentative());
  }

  Random random{1};
  const FeaturesPtr features = random_features(random, 10, 2);
  LocalMap local_map;
  PlaceCheck place{RecoveryOptions{}, Subject::stream};
};

TEST_F(TentativePlaceTest, SmallStepsAreNoJumps) {
  settle();
  for (int i = 1; i < 20; ++i) {
    find(i, 0.1 * i, 0.5 * i);
    EXPECT_FALSE(place.tentative()) << "each step is a tenth of the depth";
  }
  EXPECT_FALSE(place.take_retraction());
}

TEST_F(TentativePlaceTest, AFifthOfTheDepthIsAJump) {
  settle();
  find(1, 0.1, 0.9);
  EXPECT_FALSE(place.tentative());
  find(2, 0.2, 0.9 + 1.1);
  EXPECT_TRUE(place.tentative());
}

TEST_F(TentativePlaceTest, ACameraLostForAMomentMovedOnMeanwhile) {
  settle();
  find(1, 0.1, 0.5);
  find(6, 0.6, 3.2, Arrival::relocalised);  // 5 m/s
  EXPECT_FALSE(place.tentative()) << "half a second at that speed leads there";
  find(11, 1.1, 3.2 + 0.9 * 5, Arrival::relocalised);
  EXPECT_TRUE(place.tentative()) << "twice as far as it goes in that time";
}

// Every tenth frame is stamped when a burst arrives. Its way divided by next to nothing led so far on that the next
// place was a jump.
TEST_F(TentativePlaceTest, AFrameInABurstTellsNoVelocity) {
  settle();
  for (int i = 1; i < 40; ++i) {
    find(i, 0.1 * i - (i % 10 == 0 ? 0.09 : 0), 0.4 * i, i == 21 ? Arrival::relocalised : Arrival::tracked);
    EXPECT_FALSE(place.tentative()) << i;
  }
}

TEST_F(TentativePlaceTest, WhereACameraLostForLongIsFoundItHasJumped) {
  settle();
  find(1, 0.1, 0.5);
  find(8, 0.8, 4, Arrival::relocalised);
  EXPECT_TRUE(place.tentative()) << "seven tenths of a second at 5 m/s lead there, but it was not seen to go";
}

// Twice the lengths, and the world turned by a right angle: the way on turns and grows with it.
TEST_F(TentativePlaceTest, TheWayOnMovesWithTheMap) {
  settle();
  find(1, 0.1, 0.5);
  const Eigen::Matrix3d R_wc = so3_exp({0, 1.5707963, 0});  // the camera's right is the world's -z
  place.follow(SE3(R_wc.transpose(), Eigen::Vector3d::Zero()), 0, 2);
  TrackedFrame found = at(6, 0.6, 0);
  found.T_cw = SE3(R_wc, Eigen::Vector3d(0, 0, -2 * 0.4 * 5)).inverse();  // 0.4 s of 5 m/s
  EXPECT_TRUE(place.is_right({found, local_map, {}, nullptr}, Arrival::relocalised));
  EXPECT_FALSE(place.tentative());
}

// Things that the last frame saw too show how far the camera turned; nothing confirms a place that only looks alike.
TEST_F(TentativePlaceTest, AWideTurnIsNoJumpWhereTheLastFrameShowsIt) {
  const auto turned_by = [&](double degrees, Arrival arrival) {
    place.restart();
    settle();
    TrackedFrame found = at(1, 0.1, 0);
    found.T_cw = SE3(so3_exp({0, degrees / 57.29578, 0}), Eigen::Vector3d::Zero());
    EXPECT_TRUE(place.is_right({found, local_map, {}, nullptr}, arrival));
    return place.tentative();
  };
  EXPECT_TRUE(turned_by(30, Arrival::tracked));
  EXPECT_TRUE(turned_by(30, Arrival::relocalised));
  EXPECT_FALSE(turned_by(30, Arrival::recognised));
  EXPECT_TRUE(turned_by(70, Arrival::recognised));
  place.restart();
  settle();
  find(1, 0.1, 1.1, Arrival::recognised);
  EXPECT_TRUE(place.tentative()) << "a fifth of the depth";
}

TEST_F(TentativePlaceTest, ACameraThatStoodHasJumpedWhenItIsFoundElsewhere) {
  settle();
  find(1, 0.1, 0);
  find(6, 0.6, 1.1, Arrival::relocalised);
  EXPECT_TRUE(place.tentative());
}

TEST_F(TentativePlaceTest, AQuickTurnIsAJump) {
  for (const double degrees : {14.0, 16.0}) {
    settle();
    TrackedFrame turned = at(1, 0.1, 0);
    turned.T_cw = SE3(so3_exp({0, degrees / 57.29578, 0}), Eigen::Vector3d::Zero());
    ASSERT_TRUE(place.is_right({turned, local_map, {}, nullptr}, Arrival::tracked));
    EXPECT_EQ(place.tentative(), degrees > 15);
  }
}

// Each step of a camera of two frames a second was a jump, which took back the one before, for as long as it went on.
TEST_F(TentativePlaceTest, ASlowCameraSettlesWhileItMoves) {
  for (int i = 0; i < 5; ++i) find(i, 0.5 * i, 1.2 * i, i == 0 ? Arrival::relocalised : Arrival::tracked);
  EXPECT_FALSE(place.tentative()) << "2.4 m/s before a wall 5 m away";
  EXPECT_FALSE(place.take_retraction());
  find(5, 2.5, 1.2 * 4 + 2.6);
  EXPECT_TRUE(place.tentative()) << "half of the depth in one step";
}

// The step to the first pose there was no motion of the camera.
TEST_F(TentativePlaceTest, AJumpTellsNoVelocity) {
  settle();
  find(1, 0.1, 4, Arrival::relocalised);
  find(3, 0.3, 4);  // a frame was left out
  EXPECT_FALSE(place.take_retraction()) << "it stood where it was found";
}

TEST_F(TentativePlaceTest, TheFirstPlaceIsTentativeForASecond) {
  find(7, 3.0, 0, Arrival::relocalised);
  EXPECT_TRUE(place.tentative());
  EXPECT_EQ(place.tentative_since(), from_seconds(3.0));
  find(8, 3.5, 0.1);
  find(9, 3.9, 0.2);
  EXPECT_TRUE(place.tentative());
  find(10, 4.0, 0.3);
  EXPECT_FALSE(place.tentative());
  EXPECT_FALSE(place.tentative_since());
  place.lose();
  EXPECT_FALSE(place.take_retraction()) << "settled places stay";
}

TEST_F(TentativePlaceTest, APlaceThatIsDoubtedIsTentativeWhereverItLies) {
  settle();
  find(1, 0.1, 0.1, Arrival::relocalised);
  EXPECT_FALSE(place.tentative());
  place.doubt(at(1, 0.1, 0.1));
  EXPECT_TRUE(place.tentative());
  find(2, 0.2, 0.2);
  place.doubt(at(2, 0.2, 0.2));
  find(3, 1.15, 0.3);
  EXPECT_TRUE(place.tentative()) << "a second counts from the last doubt";
  place.lose();
  EXPECT_EQ(place.take_retraction(), 1) << "from the first doubt on";
}

TEST_F(TentativePlaceTest, LostWhileTentativeTakesBackThePosesSinceTheJump) {
  settle();
  find(5, 0.5, 20, Arrival::relocalised);
  find(6, 0.6, 20.1);
  EXPECT_FALSE(place.take_retraction());
  place.lose();
  EXPECT_FALSE(place.tentative());
  EXPECT_EQ(place.take_retraction(), 5);
  EXPECT_FALSE(place.take_retraction()) << "reported once";
  find(9, 0.9, 20.2, Arrival::relocalised);
  EXPECT_TRUE(place.tentative()) << "the place that was taken back is no place to have come from";
}

TEST_F(TentativePlaceTest, FromAWrongPlaceTheCameraComesBackToWhereItWas) {
  settle();
  find(5, 0.5, 20, Arrival::relocalised);
  place.lose();
  find(9, 0.9, 0.5, Arrival::relocalised);
  EXPECT_FALSE(place.tentative());
  find(10, 1, 20, Arrival::relocalised);
  place.lose();
  find(70, 7, 0.5, Arrival::relocalised);
  EXPECT_TRUE(place.tentative()) << "six seconds later";
}

TEST_F(TentativePlaceTest, BackWithoutALossTheTentativePlaceIsTakenBack) {
  settle();
  find(5, 0.5, 0, Arrival::relocalised, 3);
  find(9, 0.9, 0.5, Arrival::relocalised, 0);
  EXPECT_EQ(place.take_retraction(), 5);
  EXPECT_FALSE(place.tentative());
}

TEST_F(TentativePlaceTest, WhereTheMapWasMovedNothingIsKnownOfPlacesBefore) {
  settle();
  place.restart_at(at(5, 0.5, 0), 3);
  place.forget_settled();
  find(9, 0.9, 0.5, Arrival::relocalised, 0);
  EXPECT_TRUE(place.tentative());
}

TEST_F(TentativePlaceTest, FromASubmapBegunInBetweenTheCameraComesBackToWhereItWas) {
  settle();
  place.restart_at(at(5, 0.5, 0), 3);
  place.accept(at(5, 0.5, 0), 3);
  find(9, 0.9, 0.5, Arrival::relocalised, 0);
  EXPECT_FALSE(place.tentative());
}

TEST_F(TentativePlaceTest, ASubmapBegunWhileThePlaceIsTentativeIsWithoutDoubt) {
  settle();
  find(5, 0.5, 20, Arrival::relocalised);
  place.restart_at(at(6, 0.6, 0), 3);
  EXPECT_FALSE(place.tentative());
  place.accept(at(6, 0.6, 0), 3);
  place.lose();
  EXPECT_FALSE(place.take_retraction()) << "the poses in the new submap stay";
}

TEST_F(TentativePlaceTest, LostWhileSettledTheLastPlaceIsRemembered) {
  settle();
  place.lose();
  EXPECT_FALSE(place.take_retraction());
  find(9, 0.9, 0.1, Arrival::relocalised);
  EXPECT_FALSE(place.tentative()) << "it is where it was";
}

TEST_F(TentativePlaceTest, AnotherJumpTakesBackTheFirst) {
  settle();
  find(5, 0.5, 20, Arrival::relocalised);
  find(6, 0.6, 20.1);
  find(7, 0.7, 60);
  EXPECT_TRUE(place.tentative()) << "the other place is";
  EXPECT_EQ(place.take_retraction(), 5);
  find(8, 1.6, 60.1);
  EXPECT_TRUE(place.tentative()) << "a second counts from the second jump";
  place.lose();
  EXPECT_EQ(place.take_retraction(), 7);
}

TEST_F(TentativePlaceTest, OfTwoJumpsTakenBackTheEarlierIsReported) {
  settle();
  find(5, 0.5, 20, Arrival::relocalised);
  find(7, 0.7, 60);
  place.lose();
  EXPECT_EQ(place.take_retraction(), 5);
  EXPECT_FALSE(place.take_retraction());
}

TEST_F(TentativePlaceTest, ThePlaceMovesWithTheMap) {
  settle();
  place.follow(pose_at(30), 2, 1);
  find(1, 0.1, 30.1, Arrival::relocalised, 2);
  EXPECT_FALSE(place.tentative());
}

TEST_F(TentativePlaceTest, WithoutAPlaceThereIsNothingToMove) {
  place.follow(pose_at(30), 0, 1);
  find(1, 0.1, 30.1, Arrival::relocalised);
  EXPECT_TRUE(place.tentative());
}

TEST_F(TentativePlaceTest, AnotherSubmapIsAnotherPlace) {
  settle();
  find(1, 0.1, 0.1, Arrival::relocalised, 3);
  EXPECT_TRUE(place.tentative());
  place.restart_at(at(2, 5.0, 0), 4);
  place.accept(at(2, 5.0, 0), 4);
  find(3, 5.1, 0.1, Arrival::relocalised, 4);
  EXPECT_FALSE(place.tentative()) << "a submap begins where it begins";
}

TEST_F(TentativePlaceTest, AfterARestartTheCameraMayBeAnywhere) {
  find(5, 0.5, 20, Arrival::relocalised);
  place.restart();
  EXPECT_FALSE(place.tentative());
  EXPECT_FALSE(place.take_retraction());
  find(6, 0.6, 20, Arrival::relocalised);
  EXPECT_TRUE(place.tentative());
}

}  // namespace
}  // namespace covis
