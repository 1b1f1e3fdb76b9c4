// SPDX-License-Identifier: Apache-2.0
#include "covis/io/ros_camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "covis/geometry/camera_check.h"

namespace covis::io {
namespace {

using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Result<Camera> camera_of(const RosCameraInfo& info, const char* field, const Pinhole& pinhole) {
  constexpr uint32_t kLargestSide = 32767;
  if (info.width < 1 || info.height < 1 || info.width > kLargestSide || info.height > kLargestSide) {
    return fail("width and height are " + std::to_string(info.width) + " and " + std::to_string(info.height) +
                "; they must be those of the images");
  }
  if (info.binning_x > 1 || info.binning_y > 1 || info.region_x > 0 || info.region_y > 0) {
    return fail(
        "binning_x, binning_y and roi must be those of the whole image; give the camera of these images with "
        "--camera");
  }
  if (!(pinhole.fx > 0) || !(pinhole.fy > 0)) {
    return fail(std::string(field) + " holds the focal lengths " + std::to_string(pinhole.fx) + " and " +
                std::to_string(pinhole.fy) + ", which must be positive: the camera was not calibrated; give --camera");
  }
  Camera camera;
  camera.width = static_cast<int>(info.width);
  camera.height = static_cast<int>(info.height);
  camera.pinhole = pinhole;
  if (const auto problem = problem_of(camera)) return fail(std::string(field) + ": " + *problem);
  return camera;
}

bool all_zero(const std::vector<double>& values, size_t from) {
  return std::all_of(values.begin() + static_cast<ptrdiff_t>(std::min(from, values.size())), values.end(),
                     [](double value) { return value == 0; });
}

Result<Matrix3> rotation_of(const RosCameraInfo& info, const char* side) {
  const Matrix3 R = Eigen::Map<const Matrix3>(info.R.data());
  if (!((R * R.transpose() - Matrix3::Identity()).norm() < 1e-3) || R.determinant() < 0)
    return fail(std::string("R of the ") + side + " camera is not a rotation: the pair was not calibrated");
  return R;
}

// True when the images of the sensor are what P describes.
bool needs_no_rectification(const RosCameraInfo& info) {
  const auto& [K, P] = std::pair(info.K, info.P);
  return all_zero(info.D, 0) && Eigen::Map<const Matrix3>(info.R.data()).isIdentity(1e-9) && K[0] == P[0] &&
         K[4] == P[5] && K[2] == P[2] && K[5] == P[6];
}

}  // namespace

Result<Camera> raw_camera(const RosCameraInfo& info) {
  constexpr double kMostSkew = 1e-3;  // as a share of the focal length
  if (std::abs(info.K[1]) > kMostSkew * info.K[0])
    return fail("K has a skew (its second number is " + std::to_string(info.K[1]) +
                "), and must be fx 0 cx 0 fy cy 0 0 1");
  auto camera = camera_of(info, "K", {info.K[0], info.K[4], info.K[2], info.K[5], 0});
  const size_t count = info.D.size();
  const bool fisheye = (info.model == "equidistant" || info.model == "fisheye") && count == 4;
  if (!camera || (all_zero(info.D, 0) && !fisheye)) return camera;  // a fisheye lens bends rays with zeros too
  if (info.model == "plumb_bob" && (count == 4 || count == 5)) {
    camera->distortion = Distortion::brown_conrady;
  } else if ((info.model == "rational_polynomial" || info.model == "plumb_bob") && count >= 5) {
    if (!all_zero(info.D, 5)) {
      return fail("distortion_model is " + info.model +
                  " with more coefficients than k1 k2 p1 p2 k3; only those can be used. Use rectified images, or a "
                  "camera file with --camera");
    }
    camera->distortion = Distortion::brown_conrady;
  } else if (fisheye) {
    camera->distortion = Distortion::kannala_brandt;
  } else {
    return fail("distortion_model '" + info.model + "' with " + std::to_string(count) +
                " coefficients can't be used; it must be plumb_bob (4 or 5), rational_polynomial whose coefficients "
                "from the sixth on are zero, or equidistant (4)");
  }
  std::copy_n(info.D.begin(), std::min<size_t>(count, 5), camera->coefficients.begin());
  return camera;
}

Result<Camera> rectified_camera(const RosCameraInfo& info) {
  return camera_of(info, "P", {info.P[0], info.P[5], info.P[2], info.P[6], 0});
}

Result<StereoCamera> stereo_camera(const RosCameraInfo& left, const RosCameraInfo& right, StereoImages images) {
  StereoCamera stereo;
  const auto rectified = rectified_camera(left);
  if (!rectified) return tl::unexpected(rectified.error());
  const double baseline = -right.P[3] / left.P[0];  // P of the right camera: its fourth column is -fx baseline, 0, 0
  if (!(baseline > 0)) {
    return fail("P of the right camera holds the baseline " + std::to_string(baseline) +
                " m, which must be positive; are left and right exchanged, or is the pair not calibrated?");
  }
  if (images == StereoImages::rectified || (needs_no_rectification(left) && needs_no_rectification(right))) {
    const auto other = rectified_camera(right);
    if (!other) return tl::unexpected(other.error());
    if (const auto problem = problem_of_pair(rectified->pinhole, other->pinhole)) return fail("P: " + *problem);
    stereo.camera = *rectified;
    stereo.camera.pinhole.bf = rectified->pinhole.fx * baseline;
    return stereo;
  }
  const auto left_camera = raw_camera(left), right_camera = raw_camera(right);
  if (!left_camera) return tl::unexpected(left_camera.error());
  if (!right_camera) return tl::unexpected(right_camera.error());
  const auto R_rect_l = rotation_of(left, "left"), R_rect_r = rotation_of(right, "right");
  if (!R_rect_l) return tl::unexpected(R_rect_l.error());
  if (!R_rect_r) return tl::unexpected(R_rect_r.error());
  // The right rectified camera lies at (baseline, 0, 0) in the left one.
  const SE3 T_rl(R_rect_r->transpose() * *R_rect_l, -(R_rect_r->transpose() * Eigen::Vector3d(baseline, 0, 0)));
  auto made = StereoRectification::create(*left_camera, *right_camera, T_rl.normalized());
  if (!made) return tl::unexpected(made.error());
  stereo.camera = made->camera();
  stereo.rectification = std::move(*made);
  return stereo;
}

}  // namespace covis::io
