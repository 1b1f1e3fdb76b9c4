// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/path_reach.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

PoseOfFrame at(int64_t frame, double x, double turned = 0, uint32_t submap = 0) {
  PoseOfFrame pose;
  pose.frame = frame;
  pose.stamp = frame * 100'000'000;  // ns: 10 Hz
  pose.submap = submap;
  pose.T_wc = SE3(Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitY()).toRotationMatrix(), Eigen::Vector3d(x, 0, 0));
  return pose;
}

// A metre and 0.2 radians a second; frames 20 to 29 have no pose.
PathReach walk() {
  std::vector<PoseOfFrame> path;
  for (int64_t k = 10; k < 50; ++k) {
    if (k < 20 || k >= 30) path.push_back(at(k, 0.1 * static_cast<double>(k), 0.02 * static_cast<double>(k)));
  }
  return PathReach(path);
}

TEST(PathReach, AdmitsWhatLiesOnTheWay) {
  EXPECT_TRUE(walk().admits(at(22, 2.2, 0.44)));
  EXPECT_TRUE(walk().admits(at(9, 0.9, 0.18)));
}

TEST(PathReach, ALookAlikeIsTooFarAway) {
  EXPECT_FALSE(walk().admits(at(21, 5, 0.42)));
  EXPECT_FALSE(walk().admits(at(29, 2.1, 0.58))) << "the next frame is elsewhere";
  EXPECT_FALSE(walk().admits(at(22, 2.2, 1))) << "the camera never turned so fast";
}

TEST(PathReach, NothingIsKnownOfALongGapOrOfAnotherMap) {
  PathReach reach = walk();
  EXPECT_FALSE(reach.admits(at(-5, 0, 0)));
  EXPECT_FALSE(reach.admits(at(25, 2.5, 0.5)));
  EXPECT_FALSE(reach.admits(at(22, 2.2, 0.44, 1)));
  for (int64_t k = 9; k >= -4; --k) reach.add(at(k, 0.1 * static_cast<double>(k), 0.02 * static_cast<double>(k)));
  EXPECT_TRUE(reach.admits(at(-5, -0.5, -0.1))) << "from frame to frame it goes on";
}

// With two frames a second the next frame's pose is half a second away.
TEST(PathReach, SlowCamerasAreKnownFromFrameToFrame) {
  std::vector<PoseOfFrame> path;
  for (int64_t k = 0; k < 200; k += 5) {
    if (k != 50) path.push_back(at(k, 0.1 * static_cast<double>(k)));
  }
  const PathReach reach(path);
  EXPECT_TRUE(reach.admits(at(50, 5)));
  EXPECT_FALSE(reach.admits(at(50, 9))) << "too far away";
}

// From one of a thousand frames a second to the next a camera moves by less than the errors of single images.
TEST(PathReach, FastCamerasMayBeOffByTheErrorOfAnImage) {
  const auto frame = [](int64_t k, double aside) {
    PoseOfFrame pose = at(k, 0.001 * static_cast<double>(k));
    pose.stamp = k * 1'000'000;
    pose.T_wc = SE3(pose.T_wc.R(), pose.T_wc.t() + Eigen::Vector3d(0, aside, 0));
    return pose;
  };
  std::vector<PoseOfFrame> path;
  for (int64_t k = 0; k < 100; ++k) {
    if (k != 50) path.push_back(frame(k, 0));
  }
  EXPECT_TRUE(PathReach(path).admits(frame(50, 0.005)));
  EXPECT_FALSE(PathReach(path).admits(frame(50, 0.5)));
}

}  // namespace
}  // namespace covis
