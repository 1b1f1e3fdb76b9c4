// SPDX-License-Identifier: Apache-2.0
// The place in a depth image of what an image shows: the same one when the two are registered. A depth sensor is a
// camera of its own, with another focal length, beside the one of the image. Drivers register its images to those of
// the other camera, or leave that to the program. Source: two pinhole cameras with parallel axes; what a small rotation
// between them does is a shift.
#pragma once

#include <Eigen/Core>
#include <string>

namespace covis {

struct DepthRegistration {
  double scale = 1;                       // focal length of the depth camera, in those of the image's
  double shift_x = 0, shift_y = 0;        // pixels, of what is far away in the middle of the image
  double parallax_x = 0, parallax_y = 0;  // pixels, of what is one metre away

  bool any() const { return *this != DepthRegistration{}; }
  // Cameras of one device can be so.
  bool valid() const;
  // The pixel of the depth image that shows what the image shows at `pixel`. centre: the image's principal point.
  // inverse_z: 1 / metres, 0 for what is far away.
  Eigen::Vector2d pixel(const Eigen::Vector2d& pixel, const Eigen::Vector2d& centre, double inverse_z) const {
    return centre + scale * (pixel - centre) + Eigen::Vector2d(shift_x, shift_y) +
           inverse_z * Eigen::Vector2d(parallax_x, parallax_y);
  }
  friend bool operator==(const DepthRegistration&, const DepthRegistration&) = default;
};

// The camera of depth images as people know it.
struct DepthCamera {
  double fx = 0;  // pixels, along x and y
  double cx = 0, cy = 0;
  double x = 0, y = 0;  // metres to the right of the other camera, and below it
};
// fx, cx, cy: of the camera whose images depth is looked up for. depth.fx must not be 0.
DepthRegistration registration_of(const DepthCamera& depth, double fx, double cx, double cy);
DepthCamera depth_camera_of(const DepthRegistration& registration, double fx, double cx, double cy);

// "1.107 times as large, moved by 5.5 and 3.0 pixels, and by 14.0 and 0.0 at a metre"
std::string description(const DepthRegistration& registration);

}  // namespace covis
