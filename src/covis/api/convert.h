// SPDX-License-Identifier: Apache-2.0
// Values of the public interface as the system's own, and back.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "covis/core/image.h"
#include "covis/core/sensor.h"
#include "covis/covis.h"
#include "covis/geometry/camera.h"
#include "covis/slam/system.h"

namespace covis {

Pose to_pose(const SE3& T);
// Normalises the quaternion.
SE3 to_se3(const Pose& pose);
Sensor to_sensor(SensorType sensor);
inline ImageView<const uint8_t> to_view(const GreyImage& i) { return {i.data, i.width, i.height, i.stride}; }
inline ImageView<const float> to_view(const DepthImage& i) { return {i.data, i.width, i.height, i.stride}; }

// The problem of options with an impossible camera; nothing for a possible one.
std::optional<std::string> camera_problem(const SlamOptions& options);
Camera to_camera(const CameraParameters& parameters, SensorType sensor);
CameraParameters to_parameters(const Camera& camera);
// `given` with the figures in use now.
CameraParameters in_use(CameraParameters given, const Pinhole& now);

FrameResult to_result(const FrameReport& report);
Location to_location(const LocatedImage& located);
std::vector<TrajectoryPose> to_trajectory(const std::vector<PoseOfFrame>& poses);
// Without those that are members of SlamOptions.
std::vector<Setting> to_settings(const Fields& fields);
// The member of SlamOptions that says what this setting does; null for the others.
const char* member_of_options(std::string_view setting);

// Snapshots as the public interface gives them, made anew only when the system's is another. All calls are safe from
// any thread.
class PublicSnapshots {
 public:
  // Asks for the system when no other thread is here: one asked before could be older than what was made last.
  std::shared_ptr<const MapSnapshot> get(const std::function<const System&()>& current, const CameraParameters& given);

 private:
  std::mutex mutex_;  // guards what follows
  std::shared_ptr<const Snapshot> source_;
  std::shared_ptr<const MapSnapshot> latest_;
};

}  // namespace covis
