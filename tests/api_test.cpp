// SPDX-License-Identifier: Apache-2.0
// The public interface, as a program sees it, on rendered recordings. What it refuses is in
// src/covis/api/slam_test.cpp.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "covis/covis.h"
#include "rendered.h"

namespace covis {
namespace {

using ::testing::HasSubstr;

constexpr const char* kVocabulary = COVIS_SOURCE_DIR "/vocabulary/default.covis-voc";

CameraParameters parameters_of(const Camera& camera, Sensor sensor) {
  CameraParameters p;
  p.width = camera.width;
  p.height = camera.height;
  p.fx = camera.pinhole.fx;
  p.fy = camera.pinhole.fy;
  p.cx = camera.pinhole.cx;
  p.cy = camera.pinhole.cy;
  if (sensor != Sensor::monocular) p.baseline = camera.pinhole.baseline();
  return p;
}

GreyImage grey(const ImageView<const uint8_t>& v) { return {v.data, v.width, v.height, v.stride}; }
DepthImage depth(const ImageView<const float>& v) { return {v.data, v.width, v.height, v.stride}; }

// Returns the error message, or "" when there is no error.
template <class Result>
std::string error_of(const Result& result) {
  return result ? std::string() : result.error();
}

Eigen::Quaterniond orientation(const Pose& pose) { return {pose.qw, pose.qx, pose.qy, pose.qz}; }
double turned_deg(const Pose& a, const Pose& b) {
  return orientation(a).angularDistance(orientation(b)) * 180 / std::numbers::pi;
}
double apart(const Pose& a, const Pose& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

// Checks that the rotation from the first pose to each of the others equals the true one.
void expect_turned_as(const Synth& synth, const std::vector<StampedPoseResult>& poses) {
  const auto truth = [&](const StampedPoseResult& pose) {
    int i = 0;
    while (i + 1 < synth.frames() && synth.stamp(i) < pose.stamp) ++i;
    return Eigen::Quaterniond(synth.T_wc(i).R());
  };
  double most = 0;  // greatest true rotation, degrees
  for (const StampedPoseResult& pose : poses) {
    EXPECT_NEAR(orientation(pose.pose).norm(), 1, 1e-9);
    const Eigen::Quaterniond turn = orientation(poses[0].pose).inverse() * orientation(pose.pose),
                             wanted = truth(poses[0]).inverse() * truth(pose);
    EXPECT_LT(turn.angularDistance(wanted) * 180 / std::numbers::pi, 1);
    most = std::max(most, wanted.angularDistance(Eigen::Quaterniond::Identity()) * 180 / std::numbers::pi);
  }
  EXPECT_GT(most, 5) << "else nothing was compared";
}

class Api : public testing::TestWithParam<Sensor> {
 protected:
  static SensorType type(Sensor sensor) {
    return sensor == Sensor::monocular ? SensorType::monocular
           : sensor == Sensor::stereo  ? SensorType::stereo
                                       : SensorType::rgbd;
  }
  static auto track(Slam& slam, const System::Input& in) {
    switch (GetParam()) {
      case Sensor::monocular:
        return slam.track_monocular(in.stamp, grey(in.image));
      case Sensor::stereo:
        return slam.track_stereo(in.stamp, grey(in.image), grey(in.right));
      default:
        return slam.track_rgbd(in.stamp, grey(in.image), depth(in.depth));
    }
  }
  static auto locate(Slam& slam, const System::Input& in) {
    switch (GetParam()) {
      case Sensor::monocular:
        return slam.locate_monocular(grey(in.image));
      case Sensor::stereo:
        return slam.locate_stereo(grey(in.image), grey(in.right));
      default:
        return slam.locate_rgbd(grey(in.image), depth(in.depth));
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Sensors, Api, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

TEST_P(Api, TracksLocatesAndRefusesWhatDoesNotFit) {
  const Sensor sensor = GetParam();
  Recording recording(sensor, 30, 15, "desk");
  auto slam = Slam::create(parameters_of(recording.synth.camera(), sensor), type(sensor), {}, kVocabulary);
  ASSERT_TRUE(slam) << slam.error();
  const auto early = locate(**slam, recording.frame(0));
  ASSERT_TRUE(early) << early.error();
  EXPECT_FALSE(*early);  // there is no map yet

  int tracked = 0;
  for (int i = 0; i < recording.size(); ++i) {
    const auto result = track(**slam, recording.frame(i));
    ASSERT_TRUE(result) << result.error();
    tracked += result->tracked;
    EXPECT_EQ(result->tracked, result->reason.empty());
    EXPECT_EQ(result->tracked, result->state == TrackingState::tracking);
  }
  (*slam)->finish();
  EXPECT_GT(tracked, 15);
  EXPECT_GT((*slam)->points().size(), 100u);
  const auto trajectory = (*slam)->trajectory();
  ASSERT_GE(trajectory.size(), 15u);
  expect_turned_as(recording.synth, trajectory);
  // Every key frame is a frame of the trajectory and has the same pose.
  const auto key_frames = (*slam)->key_frames();
  ASSERT_FALSE(key_frames.empty());
  for (const StampedPoseResult& key_frame : key_frames) {
    const auto same = std::find_if(trajectory.begin(), trajectory.end(),
                                   [&](const StampedPoseResult& pose) { return pose.stamp == key_frame.stamp; });
    ASSERT_NE(same, trajectory.end());
    EXPECT_LT(apart(same->pose, key_frame.pose), 1e-6);
    EXPECT_LT(turned_deg(same->pose, key_frame.pose), 1e-4);
  }

  // The last tracked image is found again from the image alone, at the same place; a black image is not.
  const auto last = trajectory.back();
  const auto found = locate(**slam, recording.frame(recording.size() - 1));
  ASSERT_TRUE(found && *found);
  EXPECT_LT(apart((*found)->pose, last.pose), 0.03);
  EXPECT_LT(turned_deg((*found)->pose, last.pose), 1);
  const auto nowhere = locate(**slam, recording.black(0));
  ASSERT_TRUE(nowhere) << nowhere.error();
  EXPECT_FALSE(*nowhere);

  // An error changes nothing.
  const System::Input again = recording.frame(3);
  EXPECT_THAT(error_of(track(**slam, again)), HasSubstr("stamps must rise"));
  const GreyImage small{again.image.data, 100, 100, 100};
  EXPECT_THAT(error_of(sensor == Sensor::stereo ? (*slam)->locate_stereo(small, small)
                       : sensor == Sensor::rgbd ? (*slam)->locate_rgbd(small, depth(again.depth))
                                                : (*slam)->locate_monocular(small)),
              HasSubstr("is 100x100; the camera is 320x240"));
  EXPECT_THAT(error_of(sensor == Sensor::monocular ? (*slam)->locate_stereo(grey(again.image), grey(again.image))
                                                   : (*slam)->locate_monocular(grey(again.image))),
              HasSubstr("another sensor"));
  EXPECT_EQ((*slam)->trajectory().size(), trajectory.size());
}

// A viewer asks for all there is while frames are tracked: each answer is sound, and the thread sanitizer finds no
// race.
TEST(ApiThreads, AnyThreadMayAskWhileFramesAreTracked) {
  Recording recording(Sensor::rgbd, 30, 15, "desk");
  const auto slam =
      Slam::create(parameters_of(recording.synth.camera(), Sensor::rgbd), SensorType::rgbd, {}, kVocabulary);
  ASSERT_TRUE(slam) << slam.error();
  size_t most_poses = 0;
  int asked = 0;
  std::jthread viewer([&](const std::stop_token& stop) {
    while (!stop.stop_requested() || most_poses == 0) {
      const auto trajectory = (*slam)->trajectory();
      const auto points = (*slam)->points();
      const auto key_frames = (*slam)->key_frames();  // a moment later: there are some when there were points
      EXPECT_TRUE(std::is_sorted(trajectory.begin(), trajectory.end(),
                                 [](const auto& a, const auto& b) { return a.stamp < b.stamp; }));
      EXPECT_TRUE(points.empty() || !key_frames.empty());
      most_poses = std::max(most_poses, trajectory.size());
      ++asked;
    }
  });
  for (int i = 0; i < recording.size(); ++i) {
    const System::Input in = recording.frame(i);
    EXPECT_TRUE((*slam)->track_rgbd(in.stamp, grey(in.image), depth(in.depth))->tracked) << i;
  }
  (*slam)->finish();
  viewer.request_stop();
  viewer.join();
  EXPECT_GT(asked, 1);
  EXPECT_GT(most_poses, 0u);
  EXPECT_EQ((*slam)->trajectory().size(), static_cast<size_t>(recording.size()));
}

// A camera carried from a desk into a room, and a picture of each.
TEST(ApiMaps, APoseSaysInWhichMapItIs) {
  Recording desk(Sensor::rgbd, 20, 30, "desk"), room(Sensor::rgbd, 20, 30, "room");
  const auto slam = Slam::create(parameters_of(desk.synth.camera(), Sensor::rgbd), SensorType::rgbd,
                                 {{"tracker.new_map_after", "0.2"}}, kVocabulary);
  ASSERT_TRUE(slam) << slam.error();
  for (Recording* recording : {&desk, &room}) {
    const int map = recording == &room;
    int tracked = 0;
    for (int i = 0; i < recording->size(); ++i) {
      const System::Input in = recording->frame(i);
      const auto result = (*slam)->track_rgbd(in.stamp + map * from_seconds(10), grey(in.image), depth(in.depth));
      ASSERT_TRUE(result) << result.error();
      if (!result->tracked) continue;
      ++tracked;
      EXPECT_EQ(result->submap, map) << i;
    }
    EXPECT_GE(tracked, 10);
  }
  (*slam)->finish();
  for (Recording* recording : {&desk, &room}) {
    const int map = recording == &room;
    const System::Input in = recording->frame(19);
    const auto found = (*slam)->locate_rgbd(grey(in.image), depth(in.depth));
    ASSERT_TRUE(found && *found) << map;
    EXPECT_EQ((*found)->submap, map);
    const auto points = (*slam)->points();
    EXPECT_GT(std::count_if(points.begin(), points.end(), [&](const Point& p) { return p.submap == map; }), 100);
    for (const auto& poses : {(*slam)->trajectory(), (*slam)->key_frames()}) {
      for (const StampedPoseResult& pose : poses) EXPECT_EQ(pose.submap, pose.stamp >= from_seconds(10));
    }
  }
}

// After a jump back to the place 40 frames earlier the camera relocalises, and its poses are tentative for a second.
TEST(ApiMaps, APoseAfterAJumpIsTentativeForASecond) {
  Recording recording(Sensor::rgbd, 61);
  const auto slam =
      Slam::create(parameters_of(recording.synth.camera(), Sensor::rgbd), SensorType::rgbd, {}, kVocabulary);
  ASSERT_TRUE(slam) << slam.error();
  int64_t stamp = 0;
  const auto show = [&](int i) {
    const System::Input in = recording.frame(i);
    return (*slam)->track_rgbd(stamp += from_seconds(0.125), grey(in.image), depth(in.depth)).value();
  };
  for (int i = 0; i <= 60; ++i) {
    const FrameResult result = show(i);
    ASSERT_TRUE(result.tracked) << i;
    EXPECT_FALSE(result.tentative) << i;
  }
  FrameResult result;
  int i = 20;
  while (i < 30 && !result.tracked) result = show(i++);
  EXPECT_TRUE(result.tracked);
  EXPECT_TRUE(result.tentative);
  for (const int end = i + 10; i < end; ++i) result = show(i);
  EXPECT_TRUE(result.tracked);
  EXPECT_FALSE(result.tentative);
}

}  // namespace
}  // namespace covis
