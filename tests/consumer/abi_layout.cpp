// SPDX-License-Identifier: Apache-2.0
// Prints the layout of every struct of the public interface: what a program compiled against it relies on.
#include <covis/covis.h>

#include <cstddef>
#include <cstdio>

#pragma GCC diagnostic ignored "-Winvalid-offsetof"
#define STRUCT(type) \
  std::printf("struct %s: %zu bytes, aligned to %zu\n", #type, sizeof(covis::type), alignof(covis::type))
#define MEMBER(type, member) std::printf("  %s.%s at %zu\n", #type, #member, offsetof(covis::type, member))
#define VALUE(value) std::printf("value %s = %d\n", #value, static_cast<int>(covis::value))

int main() {
  STRUCT(CameraParameters);
  MEMBER(CameraParameters, fx);
  MEMBER(CameraParameters, baseline);
  MEMBER(CameraParameters, depth_sigma_a);
  MEMBER(CameraParameters, lens);
  MEMBER(CameraParameters, distortion);
  STRUCT(Pose);
  MEMBER(Pose, qx);
  STRUCT(RightCamera);
  MEMBER(RightCamera, pose);
  STRUCT(GreyImage);
  MEMBER(GreyImage, width);
  MEMBER(GreyImage, stride);
  STRUCT(DepthImage);
  MEMBER(DepthImage, width);
  MEMBER(DepthImage, stride);
  STRUCT(Frame);
  MEMBER(Frame, image);
  MEMBER(Frame, right);
  MEMBER(Frame, depth);
  STRUCT(FrameResult);
  MEMBER(FrameResult, reason);
  MEMBER(FrameResult, pose);
  MEMBER(FrameResult, submap);
  MEMBER(FrameResult, tentative);
  MEMBER(FrameResult, inliers);
  MEMBER(FrameResult, key_frame);
  MEMBER(FrameResult, covariance);
  STRUCT(TrackedPoint);
  MEMBER(TrackedPoint, point);
  MEMBER(TrackedPoint, x);
  STRUCT(Location);
  MEMBER(Location, submap);
  STRUCT(TrajectoryPose);
  MEMBER(TrajectoryPose, pose);
  MEMBER(TrajectoryPose, submap);
  STRUCT(Setting);
  MEMBER(Setting, type);
  MEMBER(Setting, value);
  MEMBER(Setting, min);
  MEMBER(Setting, description);
  STRUCT(SlamOptions);
  MEMBER(SlamOptions, camera);
  MEMBER(SlamOptions, right);
  MEMBER(SlamOptions, timing);
  MEMBER(SlamOptions, mode);
  MEMBER(SlamOptions, map);
  MEMBER(SlamOptions, vocabulary);
  MEMBER(SlamOptions, settings);
  STRUCT(Event);
  MEMBER(Event, stamp);
  MEMBER(Event, submap);
  MEMBER(Event, key_frame);
  MEMBER(Event, place);
  MEMBER(Event, reason);
  STRUCT(Slam);
  STRUCT(MapSnapshot);
  MEMBER(MapSnapshot, camera);
  MEMBER(MapSnapshot, submaps);
  MEMBER(MapSnapshot, key_frames);
  MEMBER(MapSnapshot, edges);
  MEMBER(MapSnapshot, points);
  MEMBER(MapSnapshot, observations);
  MEMBER(MapSnapshot, trajectory);
  STRUCT(MapSnapshot::Submap);
  MEMBER(MapSnapshot::Submap, loaded);
  MEMBER(MapSnapshot::Submap, frames);
  MEMBER(MapSnapshot::Submap, points);
  STRUCT(MapSnapshot::KeyFrame);
  MEMBER(MapSnapshot::KeyFrame, stamp);
  MEMBER(MapSnapshot::KeyFrame, pose);
  MEMBER(MapSnapshot::KeyFrame, submap);
  MEMBER(MapSnapshot::KeyFrame, parent);
  STRUCT(MapSnapshot::Edge);
  MEMBER(MapSnapshot::Edge, shared);
  MEMBER(MapSnapshot::Edge, loop);
  STRUCT(MapSnapshot::Point);
  MEMBER(MapSnapshot::Point, x);
  MEMBER(MapSnapshot::Point, submap);
  STRUCT(MapSnapshot::Observation);
  MEMBER(MapSnapshot::Observation, point);
  MEMBER(MapSnapshot::Observation, u);
  // The last value of each enum: those before it can't move without it.
  VALUE(SensorType::rgbd);
  VALUE(LensType::kannala_brandt);
  VALUE(TrackingState::lost);
  VALUE(NoPoseReason::no_key_frame_matches);
  VALUE(Timing::deterministic);
  VALUE(Mode::localisation);
  VALUE(Event::Kind::found);
  VALUE(SettingType::text);
  VALUE(LogLevel::error);
}
