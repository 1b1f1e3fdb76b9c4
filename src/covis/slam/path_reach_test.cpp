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

}  // namespace
}  // namespace covis
