// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/pose_search.h"

#include <gtest/gtest.h>

#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

class PoseSearchTest : public testing::Test {
 protected:
  PoseSearchTest() { world.add_key_frames(12, 0, 4); }

  const PointScene scene = PointScene::ring();
  SceneMap world{scene};
  PoseSearch search{RecoveryOptions{}, Subject::stream};
};

TEST_F(PoseSearchTest, TheCameraIsTheMaps) {
  search.refresh_camera(*world.shared.read());
  EXPECT_EQ(search.camera, scene.camera);
  const Pinhole refined{400, 400, 300, 200, 0};
  world.shared.write()->set_camera(refined);
  search.refresh_camera(*world.shared.read());
  EXPECT_EQ(search.camera, refined);
}

TEST_F(PoseSearchTest, TheLocalMapLiesAroundTheMatches) {
  TrackedFrame frame = frame_of(world.views[5], scene.T_cw(20));
  match_points(frame, world.views[5], world);
  search.update_local_map(world.shared, frame, world.frames[0], 80);
  EXPECT_EQ(search.local_map.reference.id, world.frames[5]);
}

TEST_F(PoseSearchTest, WithoutMatchesOfTheMapItLiesAroundTheFallback) {
  TrackedFrame frame = frame_of(world.views[5], scene.T_cw(20));
  match_points(frame, world.views[5], world);
  search.update_local_map(world.shared, frame, {}, 80);
  for (size_t f = 0; f < frame.source.size(); ++f) frame.source[f] = PointSource::depth;
  search.update_local_map(world.shared, frame, world.frames[0], 80);
  EXPECT_EQ(search.local_map.reference.id, world.frames[0]);
}

// A frame that shows all it should, at a first pose that is off by four degrees: further than any window reaches.
class SecondStart : public PoseSearchTest {
 protected:
  SecondStart() {
    search.refresh_camera(*world.shared.read());
    TrackedFrame right = frame_of(view, truth);
    match_points(right, view, world);
    search.update_local_map(world.shared, right, {}, 80);
  }
  // The true pose turned by an angle, radians.
  SE3 turned(double angle) const { return SE3(so3_exp(Eigen::Vector3d(0, angle, 0)), Eigen::Vector3d::Zero()) * truth; }
  int fit(TrackedFrame& frame) {
    search.unfitted.keep(frame);
    search.fit_local_map(options, 1, frame, figures);
    return figures.inliers;
  }

  const PointScene::View view = world.views[5];
  const SE3 truth = scene.T_cw(20);
  const SE3 astray = turned(0.07);
  const LocalMapOptions options;
  const MatchBelief belief;
  TrackFigures figures;
};

TEST_F(SecondStart, FindsWhatAFirstPoseThatIsAstrayMisses) {
  TrackedFrame frame = frame_of(view, astray);
  const int missed = fit(frame);
  search.fit_local_map_from(truth, options, 1, belief, frame, figures);
  EXPECT_GT(figures.inliers, 100);
  EXPECT_GT(figures.inliers, 2 * missed);
  EXPECT_EQ(figures.inliers, frame.matches());
  EXPECT_LT(distance(frame.T_cw, truth), 0.01);
}

// Elsewhere the map may repeat what it knows, off by its drift: a jump there is a loop's to make.
TEST_F(SecondStart, TakesNoPoseThatIsFartherFromThePrediction) {
  const SE3 predicted = turned(0.013);
  TrackedFrame frame = frame_of(view, predicted);
  const int near = fit(frame);
  const SE3 pose = frame.T_cw;
  TrackedFrame wider = frame_of(view, predicted);
  search.fit_local_map(options, 2, wider, figures);
  ASSERT_GT(figures.inliers, 1.2 * near) << "there would be more";
  fit(frame = frame_of(view, predicted));
  search.fit_local_map_from(predicted, options, 1, belief, frame, figures);
  EXPECT_EQ(figures.inliers, near);
  EXPECT_EQ(frame.T_cw.t(), pose.t());
}

TEST_F(SecondStart, LeavesAllAsItWasWhereItFindsNoMore) {
  const PointScene::View strange = edited(view, [](Features& f) {  // every third feature is like none of the map
    for (size_t i = 1; i < f.descriptor.size(); i += 3)
      f.descriptor[i].bits[0] ^= ~uint64_t{0}, f.descriptor[i].bits[1] ^= ~uint64_t{0};
  });
  const auto started = [&] {
    TrackedFrame frame = frame_of(strange, truth);
    match_points(frame, view, world, 3);
    for (size_t f = 1; f < view.point.size(); f += 3)
      frame.set_match(f, {}, scene.points[view.point[f]].position_w, PointSource::depth);
    return frame;
  };
  TrackedFrame frame = started();
  figures.first_share = 0.4;
  ASSERT_GT(fit(frame), 100);
  ASSERT_GT(frame.matches(), figures.inliers) << "points of depth";
  const TrackedFrame before = frame;
  const TrackFigures figures_before = figures;
  const std::vector<uint8_t> in_view = search.matcher.in_view(), expected = search.view.points();
  for (const SE3& start : {astray, truth}) {
    search.fit_local_map_from(start, options, 1, belief, frame, figures);
    EXPECT_EQ(frame.T_cw.t(), before.T_cw.t());
    EXPECT_EQ(frame.T_cw.R(), before.T_cw.R());
    EXPECT_EQ(frame.features, before.features);
    EXPECT_EQ(frame.points, before.points);
    EXPECT_EQ(frame.source, before.source);
    EXPECT_EQ(frame.positions, before.positions);
    EXPECT_EQ(frame.information, before.information);
    EXPECT_EQ(figures.inliers, figures_before.inliers);
    EXPECT_EQ(figures.first_share, figures_before.first_share);
    EXPECT_EQ(figures.local_in_view, figures_before.local_in_view);
    EXPECT_EQ(figures.local_expected, figures_before.local_expected);
    EXPECT_EQ(search.matcher.in_view(), in_view);
    EXPECT_EQ(search.view.points(), expected);
    ASSERT_GT(fit(frame = started()), 100);
  }
}

// Points of depth carry such a frame, and few agree by chance anywhere.
TEST_F(SecondStart, TakesNoPoseOfTooFewPoints) {
  LocalMapOptions many = options;
  many.min_inliers = 10000;
  TrackedFrame frame = frame_of(view, astray);
  fit(frame);
  const SE3 first = frame.T_cw;
  search.fit_local_map_from(truth, many, 1, belief, frame, figures);
  EXPECT_EQ(frame.T_cw.t(), first.t());
}

TEST_F(SecondStart, TheShareOfTheFirstPoseDoesNotSpeakForAnother) {
  TrackedFrame frame = frame_of(view, astray);
  figures.first_share = 0.4;
  fit(frame);
  search.fit_local_map_from(truth, options, 1, belief, frame, figures);
  EXPECT_EQ(figures.first_share, 0);
}

}  // namespace
}  // namespace covis
