// SPDX-License-Identifier: Apache-2.0
// Cameras out of sensor_msgs/CameraInfo. Source: wiki.ros.org/image_pipeline/CameraInfo.
#pragma once

#include <optional>

#include "covis/core/error.h"
#include "covis/features/rectification.h"
#include "covis/geometry/camera.h"
#include "covis/io/ros_message.h"

namespace covis::io {

// Returns the camera of images as the sensor gives them: K and D. Errors name the field.
Result<Camera> raw_camera(const RosCameraInfo& info);
// Returns the camera of rectified images: P. bf is 0.
Result<Camera> rectified_camera(const RosCameraInfo& info);

struct StereoCamera {
  Camera camera;  // that of the images to be tracked, including bf
  std::optional<StereoRectification> rectification;
};
// rectified: the images are rectified already, so that P of both cameras describes them. Otherwise they are to be
// rectified from K and D of both, and the pose of the right camera relative to the left, which R and P of both hold.
enum class StereoImages { raw, rectified };
Result<StereoCamera> stereo_camera(const RosCameraInfo& left, const RosCameraInfo& right, StereoImages images);

}  // namespace covis::io
