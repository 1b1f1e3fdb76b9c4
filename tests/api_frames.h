// SPDX-License-Identifier: Apache-2.0
// For the tests of the public interface: recordings as a program gives them to it.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "covis/covis.h"
#include "rendered.h"

namespace covis {
inline constexpr const char* kVocabulary = COVIS_SOURCE_DIR "/vocabulary/default.covis-voc";

inline CameraParameters parameters_of(const Camera& camera, Sensor sensor) {
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

inline GreyImage grey(const ImageView<const uint8_t>& v) { return {v.data, v.width, v.height, v.stride}; }
inline DepthImage depth(const ImageView<const float>& v) { return {v.data, v.width, v.height, v.stride}; }

// Returns the error message, or "" when there is no error.
template <class Result>
inline std::string error_of(const Result& result) {
  return result ? std::string() : result.error();
}

inline Eigen::Quaterniond orientation(const Pose& pose) { return {pose.qw, pose.qx, pose.qy, pose.qz}; }
inline double turned_deg(const Pose& a, const Pose& b) {
  return orientation(a).angularDistance(orientation(b)) * 180 / std::numbers::pi;
}
inline double apart(const Pose& a, const Pose& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

// Checks that the rotation from the first pose to each of the others equals the true one.
inline void expect_turned_as(const Synth& synth, const std::vector<TrajectoryPose>& poses) {
  const auto truth = [&](const TrajectoryPose& pose) {
    int i = 0;
    while (i + 1 < synth.frames() && synth.stamp(i) < pose.stamp) ++i;
    return Eigen::Quaterniond(synth.T_wc(i).R());
  };
  double most = 0;  // greatest true rotation, degrees
  for (const TrajectoryPose& pose : poses) {
    EXPECT_NEAR(orientation(pose.pose).norm(), 1, 1e-9);
    const Eigen::Quaterniond turn = orientation(poses[0].pose).inverse() * orientation(pose.pose),
                             wanted = truth(poses[0]).inverse() * truth(pose);
    EXPECT_LT(turn.angularDistance(wanted) * 180 / std::numbers::pi, 1);
    most = std::max(most, wanted.angularDistance(Eigen::Quaterniond::Identity()) * 180 / std::numbers::pi);
  }
  EXPECT_GT(most, 5) << "else nothing was compared";
}

// A recording's frame as the interface takes it.
inline Frame frame_of(const System::Input& in) {
  return {.stamp = in.stamp, .image = grey(in.image), .right = grey(in.right), .depth = depth(in.depth)};
}

inline SensorType type_of(Sensor sensor) {
  return sensor == Sensor::monocular ? SensorType::monocular
         : sensor == Sensor::stereo  ? SensorType::stereo
                                     : SensorType::rgbd;
}

inline SlamOptions options_of(const Recording& recording) {
  SlamOptions options;
  options.sensor = type_of(recording.synth.sensor());
  options.camera = parameters_of(recording.synth.camera(), recording.synth.sensor());
  options.timing = Timing::deterministic;
  options.vocabulary = kVocabulary;
  return options;
}

// Tracks the frames from first to last and returns how many have a pose.
inline int track_all(Slam& slam, Recording& recording, int first, int last) {
  int tracked = 0;
  for (int i = first; i <= last; ++i) {
    const auto result = slam.track(frame_of(recording.frame(i)));
    EXPECT_TRUE(result) << result.error();
    EXPECT_EQ(result->tracked(), result->reason == NoPoseReason::none);
    tracked += result->tracked();
  }
  return tracked;
}

}  // namespace covis
