// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/backtrack.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// A map of the second half of a walk along a wall; the first half got no pose.
class BacktrackTest : public testing::TestWithParam<Sensor> {
 protected:
  BacktrackTest() { world.add_key_frames(6, kFirst); }

  UnlocatedFrame unlocated(size_t i) const {
    const auto t = static_cast<int64_t>(i);
    return {t, t, scene.view(scene.T_cw(i), GetParam(), i).features, world.frames.front()};
  }
  // The frames before the map, newest first, as the camera walked toward it.
  std::vector<UnlocatedFrame> walk() const {
    std::vector<UnlocatedFrame> frames;
    for (size_t i = kFirst; i-- > 0;) frames.push_back(unlocated(i));
    return frames;
  }
  // Each frame is located or left.
  std::vector<LocatedFrame> backtracked(const std::vector<UnlocatedFrame>& frames) const {
    const Backtracked found = backtrack(world.shared, {.sensor = GetParam()}, frames);
    EXPECT_EQ(found.located.size() + found.left.size(), frames.size());
    for (const UnlocatedFrame& left : found.left)
      EXPECT_EQ(std::ranges::count(found.located, left.frame, &LocatedFrame::frame), 0);
    return found.located;
  }
  // The distance of a frame from its true place, metres.
  double error(const LocatedFrame& located) const {
    const SE3 T_cw = located.pose.resolved(*world.shared.read()).value().T_cw(*world.shared.read());
    return (T_cw.centre() - scene.T_wc_of(static_cast<size_t>(located.frame)).t()).norm();
  }

  static constexpr size_t kFirst = 6;
  const PointScene scene = PointScene::wall(1500);
  SceneMap world{scene, GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Sensors, BacktrackTest, testing::Values(Sensor::monocular, Sensor::rgbd));

TEST_P(BacktrackTest, LocatesTheFramesBeforeTheMap) {
  const std::vector<LocatedFrame> located = backtracked(walk());
  ASSERT_EQ(located.size(), kFirst);
  for (size_t k = 0; k < kFirst; ++k) {
    EXPECT_EQ(located[k].frame, static_cast<int64_t>(kFirst - 1 - k)) << "in the order they were given";
    EXPECT_LT(error(located[k]), 0.01);
  }
}

TEST_P(BacktrackTest, AFrameThatShowsNothingIsLeftOut) {
  std::vector<UnlocatedFrame> frames = walk();
  Features nothing = no_features();
  finish(nothing, scene.bounds);
  frames[2].features = std::make_shared<const Features>(std::move(nothing));
  const std::vector<LocatedFrame> located = backtracked(frames);
  EXPECT_EQ(located.size(), kFirst - 1);
  for (const LocatedFrame& frame : located) {
    EXPECT_NE(frame.frame, frames[2].frame);
    EXPECT_LT(error(frame), 0.01);
  }
}

TEST_P(BacktrackTest, FramesOfAnotherPlaceAreNotLocated) {
  const PointScene other = PointScene::wall(1500, 20, 2);
  std::vector<UnlocatedFrame> frames = walk();
  for (UnlocatedFrame& frame : frames)
    frame.features = other.view(other.T_cw(static_cast<size_t>(frame.frame)), GetParam()).features;
  EXPECT_TRUE(backtracked(frames).empty());
}

TEST_P(BacktrackTest, GivesUpAfterAFewFramesThatFail) {
  std::vector<UnlocatedFrame> frames;
  const PointScene other = PointScene::wall(1500, 20, 2);
  for (int64_t frame = 30; frame > 10; --frame)
    frames.push_back({frame, frame, other.view(other.T_cw(0), GetParam()).features, world.frames.front()});
  frames.push_back(unlocated(5));
  EXPECT_TRUE(backtracked(frames).empty());
  frames.back().near = world.frames[1];
  EXPECT_EQ(backtracked(frames).size(), 1u) << "another gap is another chance";
}

TEST_P(BacktrackTest, WithoutTheKeyFrameThereIsNowhereToBegin) {
  const uint32_t submap = world.shared.read()->submaps().front().id;
  world.shared.write()->erase_submap(submap);
  EXPECT_TRUE(backtracked(walk()).empty());
}

}  // namespace
}  // namespace covis
