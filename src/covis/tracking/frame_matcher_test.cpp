// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/frame_matcher.h"

#include <gtest/gtest.h>

#include "covis/core/test_allocations.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

constexpr double kWindow = 15;

class FrameMatcherTest : public testing::Test {
 protected:
  FrameMatcherTest() {
    world.add_key_frames(3, 0, 2);
    last = frame_of(last_view, scene.T_cw(4), 4);
    match_points(last, last_view, world);
  }

  // Features of a view that show a point which the last frame matched.
  int expected(const PointScene::View& view) const {
    MatchedPoints known;
    known.mark(last);
    int count = 0;
    for (const size_t p : view.point) count += known.contains(world.handles[p]);
    return count;
  }
  // Every match is that of the scene's point which the feature shows.
  void expect_right(const TrackedFrame& frame, const PointScene::View& view) const {
    for (size_t f = 0; f < view.point.size(); ++f) {
      if (!frame.on_map(f)) continue;
      EXPECT_EQ(frame.points[f], world.handles[view.point[f]]);
      EXPECT_EQ(frame.positions[f], world.shared.read()->at(frame.points[f]).position_w);
    }
  }
  // How many matches the last frame's points have in a view of it from `ahead` metres ahead, all of whose levels are
  // `coarser` coarser than the levels at which they were seen.
  int found_ahead(double ahead, int coarser, const Pinhole& camera) {
    const SE3 T_cw = SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, -ahead)) * last.T_cw;
    const PointScene::View view = edited(scene.view(T_cw), [&](Features& f) {
      for (size_t i = 0; i < f.level.size(); ++i) f.level[i] = static_cast<uint8_t>(4 + coarser);
    });
    last_view = edited(last_view, [](Features& f) { std::fill(f.level.begin(), f.level.end(), uint8_t{4}); });
    last.features = last_view.features;
    TrackedFrame frame = frame_of(view, T_cw);
    return matcher.match_last_frame(last, frame, camera, kWindow).matches;
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  PointScene::View last_view = scene.view(scene.T_cw(4));
  const PointScene::View next_view = scene.view(scene.T_cw(5));
  TrackedFrame last;
  FrameMatcher matcher;
};

TEST_F(FrameMatcherTest, TheLastFramesPointsAreFoundWhereTheyAreExpected) {
  TrackedFrame next = frame_of(next_view, scene.T_cw(5));
  const int matches = matcher.match_last_frame(last, next, scene.camera, kWindow).matches;
  EXPECT_EQ(matches, expected(next_view));
  EXPECT_GT(matches, 100);
  EXPECT_EQ(next.matches(), matches);
  expect_right(next, next_view);
}

// A key frame of a map of great images, before a frame with fewer levels.
TEST_F(FrameMatcherTest, APyramidMayHaveMoreLevelsThanTheFrames) {
  last_view = edited(last_view, [](Features& f) {
    f.pyramid = std::make_shared<const ScalePyramid>(12, f.pyramid->factor);
    for (size_t i = 0; i < f.level.size(); ++i) f.level[i] = static_cast<uint8_t>(i % 2 == 0 ? 11 : 7);
  });
  last.features = last_view.features;
  const PointScene::View coarse =
      edited(next_view, [](Features& f) { std::fill(f.level.begin(), f.level.end(), uint8_t{7}); });
  TrackedFrame next = frame_of(coarse, scene.T_cw(5));
  EXPECT_EQ(matcher.match_last_frame(last, next, scene.camera, kWindow).matches, expected(coarse));
  expect_right(next, coarse);
}

TEST_F(FrameMatcherTest, NothingIsFoundWhereTheFrameIsNot) {
  TrackedFrame next = frame_of(next_view, scene.T_cw(8));  // some 50 pixels aside
  EXPECT_LT(matcher.match_last_frame(last, next, scene.camera, kWindow).matches, 10);
  EXPECT_GT(matcher.match_last_frame(last, next, scene.camera, 100).matches, 100) << "a wider window reaches it";
}

TEST_F(FrameMatcherTest, PointsOfDepthStayPointsOfDepth) {
  for (size_t i = 0; i < last.source.size(); i += 2)
    last.set_match(i, {}, scene.points[last_view.point[i]].position_w, PointSource::depth);
  TrackedFrame next = frame_of(next_view, scene.T_cw(5));
  EXPECT_GT(matcher.match_last_frame(last, next, scene.camera, kWindow).matches, 100);
  int on_map = 0;
  for (size_t f = 0; f < next.source.size(); ++f) {
    on_map += next.on_map(f);
    EXPECT_EQ(next.on_map(f), next.points[f].valid());
  }
  EXPECT_GT(on_map, 50);
  EXPECT_LT(on_map, next.matches());
}

TEST_F(FrameMatcherTest, WhatTurnedOtherwiseThanTheBulkIsDropped) {
  const PointScene::View turned = edited(next_view, [](Features& f) {
    for (size_t i = 0; i < f.angle.size(); ++i) f.angle[i] = i % 10 == 0 ? 2.5f : 0.3f;
  });
  TrackedFrame next = frame_of(turned, scene.T_cw(5));
  const int matches = matcher.match_last_frame(last, next, scene.camera, kWindow).matches;
  EXPECT_EQ(next.matches(), matches);
  EXPECT_GT(matches, expected(turned) * 8 / 10);
  for (size_t f = 0; f < next.source.size(); f += 10) EXPECT_EQ(next.source[f], PointSource::none) << f;
}

TEST_F(FrameMatcherTest, AheadPointsMayBeSeenLargerAndBackFiner) {
  const Pinhole& camera = scene.camera;  // its baseline is 0.1 metres
  EXPECT_GT(found_ahead(0.15, 3, camera), 100);
  EXPECT_EQ(found_ahead(0.15, -3, camera), 0);
  EXPECT_GT(found_ahead(-0.15, -3, camera), 100);
  EXPECT_EQ(found_ahead(-0.15, 3, camera), 0);
  EXPECT_EQ(found_ahead(0.05, 3, camera), 0) << "by less than the baseline: the levels around";
  EXPECT_EQ(found_ahead(0.05, -3, camera), 0);
  EXPECT_GT(found_ahead(0.05, 1, camera), 100);
  EXPECT_GT(found_ahead(0.05, -1, camera), 100);
}

TEST_F(FrameMatcherTest, WithoutAKnownScaleOfTheMotionTheLevelsAroundServe) {
  Pinhole monocular = scene.camera;
  monocular.bf = 0;
  EXPECT_EQ(found_ahead(0.15, 3, monocular), 0);
  EXPECT_EQ(found_ahead(-0.15, -3, monocular), 0);
  EXPECT_GT(found_ahead(0.15, 1, monocular), 100);
}

TEST_F(FrameMatcherTest, AKeyFramesPointsAreFoundByDescriptorWhereverTheCameraIs) {
  const KeyFrameView view(*world.shared.read(), world.frames[0]);
  TrackedFrame frame = frame_of(last_view, SE3(so3_exp({0, 2, 0}), {9, 9, 9}));
  const int matches = FrameMatcher::match_key_frame(view, frame, {});
  EXPECT_GT(matches, 80);
  EXPECT_EQ(frame.matches(), matches);
  expect_right(frame, last_view);
}

TEST_F(FrameMatcherTest, AKeyFramesFeaturesWithoutPointsMatchNothing) {
  KeyFrameView view(*world.shared.read(), world.frames[0]);
  for (size_t i = 0; i < view.points.size(); ++i) {
    if (i % 4 != 0) view.points[i] = {};
  }
  TrackedFrame frame = frame_of(world.views[0], scene.T_cw(0));
  EXPECT_EQ(static_cast<size_t>(FrameMatcher::match_key_frame(view, frame, {})), (view.points.size() + 3) / 4);
}

class LocalMapSearchTest : public FrameMatcherTest {
 protected:
  LocalMapSearchTest() { local_map.update(*world.shared.read(), {}, world.frames[1], 80); }

  const MatchGate gate = MatchGate::local_map(4, 2.5, 0.8);
  LocalMap local_map;
  TrackedFrame frame = frame_of(last_view, scene.T_cw(4));
};

TEST_F(LocalMapSearchTest, FindsEveryPointInView) {
  const int in_view = matcher.match_local_map(local_map, frame, scene.camera, gate);
  EXPECT_EQ(in_view, std::count(matcher.in_view().begin(), matcher.in_view().end(), 1));
  EXPECT_EQ(frame.matches(), in_view) << "all that is in view is seen in this scene";
  EXPECT_GT(in_view, 150);
  EXPECT_LT(in_view, local_map.size());
  expect_right(frame, last_view);
}

TEST_F(LocalMapSearchTest, LeavesWhatIsMatchedAndCountsItInView) {
  TrackedFrame all = frame;
  const int in_view = matcher.match_local_map(local_map, all, scene.camera, gate);
  // Each of the first 40 has the point of the next: wrong, but theirs.
  for (size_t f = 0; f < 40; ++f) frame.set_match(f, all.points[f + 1], all.positions[f + 1], PointSource::map);
  EXPECT_EQ(matcher.match_local_map(local_map, frame, scene.camera, gate), in_view);
  for (size_t f = 0; f < 40; ++f) EXPECT_EQ(frame.points[f], all.points[f + 1]) << f;
  for (size_t f = 42; f < frame.points.size(); ++f) EXPECT_EQ(frame.points[f], all.points[f]) << f;
}

TEST_F(LocalMapSearchTest, APointOfTheMapTakesThePlaceOfDepth) {
  const size_t f = 7;
  frame.set_match(f, {}, {1, 2, 3}, PointSource::depth);
  matcher.match_local_map(local_map, frame, scene.camera, gate);
  EXPECT_TRUE(frame.on_map(f));
  EXPECT_EQ(frame.points[f], world.handles[last_view.point[f]]);
}

class FitPoseTest : public FrameMatcherTest {
 protected:
  FitPoseTest() { match_points(frame, last_view, world); }

  const SE3 truth = scene.T_cw(4);
  const LocalMap local_map;
  TrackedFrame frame = frame_of(last_view, SE3(so3_exp({0.01, -0.02, 0.01}), {0.05, -0.05, 0.1}) * truth);
};

TEST_F(FitPoseTest, ThePoseIsTheOneTheMatchesAgreeOn) {
  const int matches = frame.matches();
  const int on_map = matcher.fit_pose(frame, local_map, scene.camera);
  EXPECT_LT(distance(frame.T_cw, truth), 1e-4);
  EXPECT_EQ(on_map, matches);
  EXPECT_GT(frame.information.determinant(), 0);
}

TEST_F(FitPoseTest, MatchesThatDisagreeAreDropped) {
  for (size_t f = 0; f < 60; f += 2) std::swap(frame.positions[f], frame.positions[f + 1]);
  const int matches = frame.matches();
  const int on_map = matcher.fit_pose(frame, local_map, scene.camera);
  EXPECT_LT(distance(frame.T_cw, truth), 1e-4);
  EXPECT_EQ(frame.matches(), on_map);
  EXPECT_LE(on_map, matches - 50);
  EXPECT_GE(on_map, matches - 60);
  for (size_t f = 60; f < frame.source.size(); ++f) EXPECT_EQ(frame.on_map(f), frame.points[f].valid());
}

TEST_F(FitPoseTest, DepthHoldsThePoseAndIsNotReportedOnTheMap) {
  frame.clear_matches();
  for (size_t f = 0; f < frame.source.size(); f += 3)
    frame.set_match(f, {}, scene.points[last_view.point[f]].position_w, PointSource::depth);
  frame.set_match(1, world.handles[last_view.point[1]], scene.points[last_view.point[1]].position_w, PointSource::map);
  EXPECT_EQ(matcher.fit_pose(frame, local_map, scene.camera), 1);
  EXPECT_LT(distance(frame.T_cw, truth), 1e-4);
}

// Most of what the frame shows has moved by 30 cm, with the depths that the last frame gave it.
TEST_F(FitPoseTest, SettledPointsLeadBeforeOthers) {
  LocalMap settled;
  settled.update(*world.shared.read(), {}, world.frames.back(), 80);
  int still = 0, moved = 0;
  for (size_t f = 0; f < frame.source.size(); ++f) {
    if (!frame.on_map(f)) continue;
    if (still < 60 && !settled.is_new(frame.points[f])) {
      ++still;
    } else {
      frame.set_match(f, {}, frame.positions[f] + Eigen::Vector3d(0.3, 0, 0), PointSource::depth);
      ++moved;
    }
  }
  ASSERT_EQ(still, 60);
  ASSERT_GT(moved, 90);
  TrackedFrame led = frame;
  EXPECT_EQ(matcher.fit_pose(led, settled, scene.camera), 60);
  EXPECT_LT(distance(led.T_cw, truth), 1e-4);
}

// A thing that moved by a centimetre, within the bound of its matches: it would draw the pose with it.
TEST_F(FitPoseTest, WhatMovesTakesNoPartWhereEnoughIsLeft) {
  const auto fit = [&](int still, bool known) {
    TrackedFrame copy = frame;
    for (size_t f = 0; f < copy.source.size(); ++f) {
      if (!copy.on_map(f) || still-- > 0) continue;
      copy.set_match(f, {}, copy.positions[f] + Eigen::Vector3d(0.01, 0, 0), PointSource::depth);
      if (known) copy.moved[f] = copy.stamp;
    }
    matcher.fit_pose(copy, local_map, scene.camera);
    return copy;
  };
  const TrackedFrame apart = fit(60, true);
  EXPECT_LT(distance(apart.T_cw, truth), 1e-4);
  EXPECT_EQ(apart.matches(), 60);
  EXPECT_EQ(std::count(apart.was_refused.begin(), apart.was_refused.end(), 1), frame.matches() - 60);
  EXPECT_GT(distance(fit(60, false).T_cw, truth), 1e-3) << "unknown, it takes part";
  EXPECT_GT(fit(40, true).matches(), 40) << "where too few are left it takes part too";
}

TEST_F(FitPoseTest, PointsOfTheMapOnWhatMovesDoNotLead) {
  int still = 0;
  for (size_t f = 0; f < frame.source.size(); ++f) {
    if (!frame.on_map(f) || still++ < 60) continue;
    frame.positions[f] += Eigen::Vector3d(0.3, 0, 0);
    frame.moved[f] = frame.stamp;
  }
  ASSERT_GT(still, 150);
  EXPECT_EQ(matcher.fit_pose(frame, local_map, scene.camera), 60);
  EXPECT_LT(distance(frame.T_cw, truth), 1e-4);
}

TEST_F(FrameMatcherTest, AMatchTakesOverThatItsFeatureMoved) {
  last.stamp = from_seconds(1);
  for (size_t f = 0; f < last.source.size(); ++f) {
    if (last_view.point[f] % 2 == 0) last.moved[f] = last.stamp;
  }
  TrackedFrame next = frame_of(next_view, scene.T_cw(5), 5, from_seconds(1.1));
  const auto expect_taken = [&](const char* how) {
    for (size_t f = 0; f < next.source.size(); ++f)
      EXPECT_EQ(next.moves(f), next.on_map(f) && next_view.point[f] % 2 == 0) << how << " " << f;
  };
  ASSERT_GT(matcher.match_last_frame(last, next, scene.camera, kWindow).matches, 100);
  expect_taken("by place");
  ASSERT_GT(FrameMatcher::match_frame(last, next, {}), 100);
  expect_taken("by descriptor");
  next.clear_matches();
  expect_taken("without matches");
}

TEST_F(FitPoseTest, TooFewMatchesLeaveThePoseAsItWas) {
  for (size_t f = 2; f < frame.source.size(); ++f) frame.drop_match(f);
  const SE3 before = frame.T_cw;
  const int on_map = matcher.fit_pose(frame, local_map, scene.camera);
  EXPECT_EQ(on_map, 0);
  EXPECT_TRUE(frame.information.isZero());
  EXPECT_EQ(frame.T_cw.t(), before.t());
}

TEST_F(LocalMapSearchTest, ASteadyStateAllocatesNothing) {
  TrackedFrame next = frame_of(next_view, scene.T_cw(5));
  const auto track = [&] {
    next.start(next_view.features, 5, 5);
    next.T_cw = scene.T_cw(5);
    matcher.match_last_frame(last, next, scene.camera, kWindow);
    matcher.fit_pose(next, local_map, scene.camera);
    matcher.match_local_map(local_map, next, scene.camera, gate);
    return matcher.fit_pose(next, local_map, scene.camera);
  };
  track();
  const long before = own_allocations;
  EXPECT_GT(track(), 150);
  EXPECT_EQ(own_allocations - before, 0);
}

}  // namespace
}  // namespace covis
