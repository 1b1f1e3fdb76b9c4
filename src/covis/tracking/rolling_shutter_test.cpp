// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/rolling_shutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/test_allocation_counts.h"
#include "covis/features/straightening.h"
#include "covis/features/test_rolling.h"
#include "covis/tracking/frame_matcher.h"
#include "covis/tracking/motion_model.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

constexpr int kRows = 480;
constexpr ShutterOptions kGiven{kRows}, kSought{kRows, ShutterOptions::RowTime::sought};
constexpr double kElapsed = 0.03;  // seconds from frame to frame

PointScene noisy_wall() {
  PointScene scene = PointScene::wall(1200, 30);
  scene.noise = 0.5;
  return scene;
}

// A camera that sways as it goes along a wall. The turn between the rows is in the keypoints of the map's key frames.
struct SwayingCamera {
  explicit SwayingCamera(double with_readout, double given_fx = 1, double given_cy = 0) : readout(with_readout) {
    given.fx *= given_fx;
    given.fy *= given_fx;
    given.cy += given_cy;
  }

  SE3 T_cw(double k) const {
    const double sway = pace * k;
    const Eigen::Vector3d angles(0.15 * std::sin(0.12 * sway), 0.4 * std::cos(0.08 * sway),
                                 0.15 * std::sin(0.1 * sway));
    const Eigen::Vector3d place(0.02 * k, 0.05 * std::sin(0.05 * k), 0);
    return SE3(so3_exp(angles), Eigen::Vector3d::Zero()) * SE3(Eigen::Matrix3d::Identity(), -place);
  }
  // The turn of the rays in frame k, radians a second.
  Eigen::Vector3d rate(double k) const {
    return MotionModel::turn_rate(T_cw(k + 0.5) * T_cw(k - 0.5).inverse(), from_seconds(kElapsed));
  }
  PointScene::View rolled(const PointScene::View& view, int k) const {
    return edited(view, [&](Features& f) {
      roll(scene.camera, readout / kRows * rate(k), f);
      f.exposure.rate = rate(k);
    });
  }
  PointScene::View seen(int k) const {
    PointScene::View view = scene.view(T_cw(k), Sensor::monocular, static_cast<uint64_t>(1000 + k));
    view = rolled(view, k);
    return edited(view, [](Features& f) { f.exposure = {}; });  // nobody knows the turn of a frame that comes
  }
  void add_key_frame(int k) {
    const KeyFrameId id = world.add(T_cw(k));
    world.shared.write()->set_features(id, straightened(*rolled(world.views.back(), k).features, given));
  }
  // Tracks frames, with poses as they really are or as they are fitted.
  enum class Poses { fitted, true_ones };
  void track(RollingShutter& shutter, int frames, Poses poses = Poses::fitted) {
    SE3 last = T_cw(0);
    for (int k = 0; k < frames; ++k) {
      const Timestamp stamp = from_seconds(kElapsed * k);
      if (k % every == 0) add_key_frame(k);
      const PointScene::View view = seen(k), straight{shutter.straighten(view.features, given, stamp), view.point};
      frame = frame_of(straight, T_cw(k), k, stamp);
      match_points(frame, straight, world);
      if (poses == Poses::fitted) {
        matcher.fit_pose(frame, LocalMap(), given);
        if (k % every == 0) world.shared.write()->set_pose(world.frames.back(), frame.T_cw);
      }
      refuse_far_rows();
      if (k > 0) shutter.follow({last, stamp - from_seconds(kElapsed)}, given, frame);
      last = frame.T_cw;
      const ShutterResponse response = shutter.compare(frame, given, *world.shared.read(), world.frames.back());
      if (!response.move.isZero(0)) note_errors(response, k);
    }
  }
  void refuse_far_rows() {
    if (refusal == Refusal::none) return;
    for (size_t i = 0; i < frame.source.size(); ++i) {
      if (std::abs(frame.features->y[i] - given.cy) > kRows / 200.0) frame.refuse_match(i);
    }
    if (refusal == Refusal::forgotten) frame.refused.clear();
  }
  // The errors of a frame's pose beside its key frame, as it was fitted and as the true readout corrects it.
  void note_errors(const ShutterResponse& response, int k) {
    const SE3 fitted = frame.T_cw * world.shared.read()->at(world.frames.back()).T_cw.inverse();
    const SE3 truth = T_cw(k) * T_cw(k - k % every).inverse();
    as_fitted += (fitted * truth.inverse()).log().norm();
    corrected += (response.corrected(fitted, readout / kRows) * truth.inverse()).log().norm();
  }

  double readout;
  double pace = 1;  // how fast it sways
  int every = 10;   // frames from key frame to key frame
  // Matches far from the middle row are refused, and forgotten also.
  enum class Refusal { none, of_far_rows, forgotten } refusal = Refusal::none;
  const PointScene scene = noisy_wall();
  Pinhole given = scene.camera;
  SceneMap world{scene, Sensor::monocular};
  FrameMatcher matcher;
  TrackedFrame frame;  // the last one
  double as_fitted = 0, corrected = 0;
};

double found_readout(const RollingShutter& shutter, const Pinhole& camera) {
  return shutter.found(camera).value_or(ShutterChange()).to * kRows;
}

TEST(RollingShutter, IsFoundWhereTheCameraTurns) {
  for (const double readout : {0.02, -0.02}) {
    SwayingCamera camera(readout);
    RollingShutter shutter(kSought);
    camera.track(shutter, 200);
    EXPECT_NEAR(found_readout(shutter, camera.given), readout, 0.3 * std::abs(readout));
  }
}

// As poses do that no readout is known to: then only those refused tell it.
TEST(RollingShutter, IsFoundByMatchesThatPosesRefuse) {
  for (const bool forgotten : {false, true}) {
    SwayingCamera camera(0.02);
    camera.every = 30;
    camera.refusal = forgotten ? SwayingCamera::Refusal::forgotten : SwayingCamera::Refusal::of_far_rows;
    RollingShutter shutter(kSought);
    camera.track(shutter, 150);
    EXPECT_NEAR(found_readout(shutter, camera.given), forgotten ? 0 : 0.02, 0.1 * 0.02);
  }
}

TEST(RollingShutter, PosesAreCorrectedByWhatTheReadoutDoesToThem) {
  for (const double given : {0.0, 0.01}) {
    SwayingCamera camera(0.02);
    camera.given.row_time = given / kRows;
    RollingShutter shutter(kSought);
    camera.track(shutter, 100);
    EXPECT_GT(camera.as_fitted, 0);
    EXPECT_LT(camera.corrected, 0.8 * camera.as_fitted) << "tracked with " << given << " s";
  }
}

TEST(RollingShutter, IsNotFoundWhereAllRowsAreExposedAtOnce) {
  SwayingCamera exact(0), other_focal_length(0, 1.02), other_row(0, 1, 10);
  other_row.pace = 0.15;  // it goes on turning as it turned in its key frame
  other_row.every = 30;
  for (SwayingCamera* camera : {&exact, &other_focal_length, &other_row}) {
    RollingShutter shutter(kSought);
    camera->track(shutter, 200);
    EXPECT_FALSE(shutter.found(camera->given)) << camera->given.fx << " " << camera->given.cy;
  }
}

TEST(RollingShutter, OneThatTheCameraHasIsTakenOutOfFramesAndOfKeyFrames) {
  SwayingCamera camera(0.02);
  camera.given.row_time = 0.02 / kRows;
  RollingShutter shutter(kSought);
  camera.track(shutter, 60);
  EXPECT_FALSE(shutter.found(camera.given)) << "it is the camera's";
  const Features& straight = *camera.frame.features;
  const Eigen::Vector3d rate = camera.rate(59);
  EXPECT_NEAR((shutter.turn_rate() - rate).norm(), 0, 0.4 * rate.norm()) << "it is smoothed, and late";
  EXPECT_EQ(straight.exposure.rate, shutter.turn_rate());
  EXPECT_EQ(straight.exposure.row_time, camera.given.row_time);
  const PointScene::View with_turn = camera.seen(59);
  double before = 0, after = 0;  // squared pixels from where the points are
  for (size_t i = 0; i < straight.x.size(); ++i) {
    const Eigen::Vector3d p_c = camera.T_cw(59) * camera.scene.points[with_turn.point[i]].position_w;
    const Eigen::Vector2d at = camera.given.project(p_c);
    before += (Eigen::Vector2d(with_turn.features->x[i], with_turn.features->y[i]) - at).squaredNorm();
    after += (Eigen::Vector2d(straight.x[i], straight.y[i]) - at).squaredNorm();
  }
  EXPECT_LT(after, 0.3 * before);
}

TEST(RollingShutter, OneThatProvesToBeNoneIsGivenBack) {
  SwayingCamera camera(0);
  camera.given.row_time = 0.012 / kRows;
  RollingShutter shutter(kSought);
  camera.track(shutter, 200);
  const std::optional<ShutterChange> change = shutter.found(camera.given);
  ASSERT_TRUE(change);
  EXPECT_EQ(change->from, camera.given.row_time);
  EXPECT_EQ(change->to, 0);
}

TEST(RollingShutter, TheEstimateGoesOnWithAnotherValueAndBeginsAnewWithNone) {
  SwayingCamera camera(0.02);
  camera.given.row_time = 0.012 / kRows;
  RollingShutter shutter(kSought);
  camera.track(shutter, 200);
  ASSERT_TRUE(shutter.found(camera.given));
  camera.given.row_time = 0.013 / kRows;
  camera.track(shutter, 5);
  EXPECT_TRUE(shutter.found(camera.given));
  camera.given.row_time = 0;
  camera.track(shutter, 5);
  EXPECT_FALSE(shutter.found(camera.given));
}

TEST(RollingShutter, NobodyLooksForOneThatIsGiven) {
  SwayingCamera camera(0.02);
  RollingShutter shutter(kGiven);
  camera.track(shutter, 120);
  EXPECT_FALSE(shutter.found(camera.given));
  EXPECT_EQ(camera.frame.features->exposure.row_time, 0);
  EXPECT_FALSE(shutter.turn_rate().isZero()) << "key frames are to know it all the same";
}

TEST(RollingShutter, ATurnIsForgottenAfterAPauseAndBelievedOfNoCameraThatFast) {
  SwayingCamera camera(0);
  camera.given.row_time = 0.02 / kRows;
  RollingShutter shutter(kGiven);
  camera.track(shutter, 3, SwayingCamera::Poses::true_ones);
  const PointScene::View view = camera.seen(3);
  const auto taken = [&](double seconds) {
    return shutter.straighten(view.features, camera.given, from_seconds(seconds))->exposure.rate;
  };
  EXPECT_EQ(taken(3 * kElapsed), shutter.turn_rate());
  EXPECT_FALSE(shutter.turn_rate().isZero());
  EXPECT_TRUE(taken(3).isZero());
  shutter.follow({camera.T_cw(2), from_seconds(2 * kElapsed)}, camera.given,
                 frame_of(view, camera.T_cw(30), 3, from_seconds(3)));
  EXPECT_TRUE(shutter.turn_rate().isZero()) << "it may have turned there and back";

  TrackedFrame jumped = frame_of(view, SE3(so3_exp({0, 1, 0}), Eigen::Vector3d::Zero()), 4, from_seconds(3.03));
  shutter.follow({SE3(), from_seconds(3)}, camera.given, jumped);
  EXPECT_TRUE(shutter.turn_rate().isZero()) << "a radian in 30 ms";
}

TEST(RollingShutter, AFrameThatGotOtherFeaturesKeepsThem) {
  SwayingCamera camera(0.02);
  camera.given.row_time = 0.02 / kRows;
  RollingShutter shutter(kGiven);
  const PointScene::View view = camera.seen(1);
  shutter.straighten(view.features, camera.given, from_seconds(kElapsed));
  const TrackedFrame other = frame_of(view, camera.T_cw(1), 1, from_seconds(kElapsed));
  const Features before = *other.features;
  shutter.follow({camera.T_cw(0), 0}, camera.given, other);
  EXPECT_EQ(other.features->x, before.x);
}

TEST(RollingShutter, ComparesViewsWithoutAllocations) {
  SwayingCamera camera(0.02);
  RollingShutter shutter(kSought);
  camera.track(shutter, 15);
  const auto map = camera.world.shared.read();
  const long before = own_allocations;
  EXPECT_FALSE(shutter.compare(camera.frame, camera.given, *map, camera.world.frames.back()).move.isZero(0));
  EXPECT_EQ(own_allocations, before);
}

TEST(RollingShutter, AllocatesNothingInTheSteadyState) {
  SwayingCamera camera(0.02);
  camera.given.row_time = 0.02 / kRows;
  RollingShutter shutter(kGiven);
  const FeaturesPtr view = camera.seen(3).features;
  for (int k = 0; k < 5; ++k) shutter.straighten(view, camera.given, 0);
  const long before = own_allocations;
  shutter.straighten(view, camera.given, 0);
  EXPECT_EQ(own_allocations, before);
}

}  // namespace
}  // namespace covis
