// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/match_alignment.h"

#include <gtest/gtest.h>

#include "covis/core/test_allocation_counts.h"
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
    matcher.fit_pose(frame, LocalMap(), scene.camera);
    return frame;
  }
  void refine(TrackedFrame& frame) { alignment.refine_pose(&world.shared, scene.camera, {}, frame); }
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

TEST_F(MatchAlignmentTest, WhileTheMapMayNotBeReadTheViewsServeThatWereKept) {
  TrackedFrame frame = fitted(100);
  TrackedFrame later = frame, unknown = frame;
  alignment.refine_pose(nullptr, scene.camera, {}, unknown);
  EXPECT_EQ(unknown.T_cw.t(), frame.T_cw.t()) << "none were kept";
  {
    const auto map = world.shared.read();
    PointSet points;
    points.id = world.handles;
    alignment.keep_views(*map, points);
  }
  refine(frame);
  for (const KeyFrameId id : world.frames) world.shared.write()->set_pose(id, SE3());
  alignment.refine_pose(nullptr, scene.camera, {}, later);
  EXPECT_EQ(later.T_cw.t(), frame.T_cw.t());
  EXPECT_EQ(later.information, frame.information);
}

TEST_F(MatchAlignmentTest, WhatDoesNotFitIsLeftOutAndStaysAMatch) {
  TrackedFrame frame = fitted(100);
  TrackedFrame other = frame;
  size_t moved = 0;
  for (size_t i = 0; i < other.source.size() && moved < 60; i += 3) {
    if (!other.on_map(i)) continue;
    other.positions[i].x() += 0.04;  // some three pixels, all to one side
    ++moved;
  }
  refine(frame);
  refine(other);
  EXPECT_EQ(other.matches(), frame.matches());
  EXPECT_LT((other.T_cw * frame.T_cw.inverse()).log().norm(), 1e-3);
}

TEST_F(MatchAlignmentTest, APoseThatMostMatchesDenyStays) {
  TrackedFrame frame = fitted(100);
  Random random(3);
  for (Eigen::Vector3d& position : frame.positions) position.x() += 0.1 * random.normal();
  const SE3 before = frame.T_cw;
  refine(frame);
  EXPECT_EQ(frame.T_cw.t(), before.t());
}

TEST_F(MatchAlignmentTest, InAMapThatHasMovedThePoseStays) {
  TrackedFrame frame = fitted(100);
  const SE3 before = frame.T_cw;
  const uint64_t moves = world.shared.read()->moves();
  alignment.refine_pose(&world.shared, scene.camera, moves + 1, frame);
  EXPECT_EQ(frame.T_cw.t(), before.t());
  alignment.refine_pose(&world.shared, scene.camera, moves, frame);
  EXPECT_NE(frame.T_cw.t(), before.t());
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
