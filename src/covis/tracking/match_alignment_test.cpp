// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/match_alignment.h"

#include <gtest/gtest.h>

#include "covis/tracking/frame_matcher.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

// Key frames without noise, and views with.
struct MatchAlignmentTest : testing::Test {
  void SetUp() override {
    scene.patches = true;
    world.add_key_frames(4);
    noisy = scene;
    noisy.noise = 0.5;
  }
  TrackedFrame fitted(uint64_t seed) {
    const PointScene::View view = noisy.view(scene.T_cw(3), Sensor::monocular, seed);
    TrackedFrame frame = frame_of(view, scene.T_cw(3));
    match_points(frame, view, world);
    matcher.fit_pose(frame, scene.camera);
    return frame;
  }
  void refine(TrackedFrame& frame) { alignment.refine_pose(world.shared, scene.camera, 30, {}, frame); }
  double error_of(const TrackedFrame& frame) const { return (frame.T_cw * scene.T_wc_of(3)).log().norm(); }

  PointScene scene = PointScene::wall();
  SceneMap world{scene, Sensor::monocular};
  PointScene noisy;
  FrameMatcher matcher;
  MatchAlignment alignment;
};

TEST_F(MatchAlignmentTest, ThePoseIsCloser) {
  double before = 0, after = 0;
  for (uint64_t seed = 100; seed < 120; ++seed) {
    TrackedFrame frame = fitted(seed);
    before += error_of(frame);
    const double information = frame.information.trace();
    refine(frame);
    after += error_of(frame);
    EXPECT_GT(frame.information.trace(), information);
  }
  EXPECT_LT(after, before / 3);
}

TEST_F(MatchAlignmentTest, WhatDoesNotFitIsDropped) {
  TrackedFrame frame = fitted(100);
  const int matches = frame.matches();
  int moved = 0;
  for (size_t i = 0; i < frame.source.size() && moved < 20; i += 3) {
    if (!frame.on_map(i)) continue;
    frame.positions[i].x() += 0.04;  // some three pixels
    ++moved;
  }
  refine(frame);
  EXPECT_LE(frame.matches(), matches - moved * 3 / 4);
  EXPECT_GE(frame.matches(), (matches - moved) * 9 / 10);
}

TEST_F(MatchAlignmentTest, APoseThatMostMatchesDenyStays) {
  TrackedFrame frame = fitted(100);
  Random random(3);
  for (Eigen::Vector3d& position : frame.positions) position.x() += 0.1 * random.normal();
  const SE3 before = frame.T_cw;
  const int matches = frame.matches();
  refine(frame);
  EXPECT_EQ(frame.T_cw.t(), before.t());
  EXPECT_EQ(frame.matches(), matches);
}

TEST_F(MatchAlignmentTest, InAMapThatHasMovedEverythingStays) {
  TrackedFrame frame = fitted(100);
  const SE3 before = frame.T_cw;
  const uint64_t moves = world.shared.read()->moves();
  EXPECT_FALSE(alignment.refine_pose(world.shared, scene.camera, 30, moves + 1, frame));
  EXPECT_FALSE(alignment.refine_pose(world.shared, scene.camera, 10000, moves, frame)) << "too few are left";
  EXPECT_EQ(frame.T_cw.t(), before.t());
  EXPECT_TRUE(alignment.refine_pose(world.shared, scene.camera, 30, moves, frame));
}

TEST_F(MatchAlignmentTest, WithoutPatchesEverythingStays) {
  scene.patches = noisy.patches = false;
  TrackedFrame frame = fitted(100);
  const SE3 before = frame.T_cw;
  refine(frame);
  EXPECT_EQ(frame.T_cw.t(), before.t());
}

TEST_F(MatchAlignmentTest, AllocatesNothingInTheSteadyState) {
  TrackedFrame frame = fitted(100);
  refine(frame);
  const long before = own_allocations;
  refine(frame);
  EXPECT_EQ(own_allocations, before);
}

}  // namespace
}  // namespace covis
