// SPDX-License-Identifier: Apache-2.0
#include "covis/io/rectification.h"

#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

namespace covis::io {

struct StereoRectification::Maps {
  cv::Mat fixed, fraction;  // fixed-point form of cv::remap's maps
};

namespace {

// For each pixel of the rectified camera, the pixel of the original camera.
template <class Maps>
std::shared_ptr<const Maps> make_maps(const Camera& rectified, const Camera& from,
                                      const Eigen::Matrix3d& R_from_rectified) {
  cv::Mat x(rectified.height, rectified.width, CV_32F), y(rectified.height, rectified.width, CV_32F);
  for (int v = 0; v < rectified.height; ++v) {
    for (int u = 0; u < rectified.width; ++u) {
      const auto pixel = from.project(R_from_rectified * rectified.pinhole.unproject(u, v));
      x.at<float>(v, u) = pixel ? static_cast<float>(pixel->x()) : -1e4f;
      y.at<float>(v, u) = pixel ? static_cast<float>(pixel->y()) : -1e4f;
    }
  }
  auto maps = std::make_shared<Maps>();
  cv::convertMaps(x, y, maps->fixed, maps->fraction, CV_16SC2);
  return maps;
}

}  // namespace

Result<StereoRectification> StereoRectification::create(const Camera& left, const Camera& right, const SE3& T_rl) {
  if (left.width != right.width || left.height != right.height) {
    return fail("both images must have one size; the left is " + std::to_string(left.width) + "x" +
                std::to_string(left.height) + ", the right " + std::to_string(right.width) + "x" +
                std::to_string(right.height));
  }
  const Eigen::Vector3d right_in_left = T_rl.centre();
  const double baseline = right_in_left.norm();
  if (!(baseline > 1e-4) || right_in_left.x() < 0.5 * baseline) {
    return fail("the right camera must lie to the right of the left one; its centre is at (" +
                std::to_string(right_in_left.x()) + ", " + std::to_string(right_in_left.y()) + ", " +
                std::to_string(right_in_left.z()) + ") m in the left camera");
  }
  // x points along the baseline, z as close as possible to the mean of both optical axes.
  const Eigen::Vector3d x = right_in_left / baseline;
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ() + T_rl.R().transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = axis.cross(x).normalized();
  Eigen::Matrix3d R_left_rectified;
  R_left_rectified << x, y, x.cross(y);

  StereoRectification result;
  result.T_left_rectified_ = SE3(R_left_rectified, Eigen::Vector3d::Zero());
  Camera& camera = result.camera_;
  camera.width = left.width;
  camera.height = left.height;
  const double f = (left.pinhole.fx + left.pinhole.fy + right.pinhole.fx + right.pinhole.fy) / 4;
  camera.pinhole = {f, f, left.width / 2.0, left.height / 2.0, f * baseline};
  const Eigen::Matrix3d R_right_rectified = T_rl.R() * R_left_rectified;
  // Shift the principal point by the mean offset of both image centres, so that both stay near the centre.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  int count = 0;
  for (const auto& [from, R] : {std::pair{&left, R_left_rectified}, std::pair{&right, R_right_rectified}}) {
    if (const auto ray = from->unproject({from->width / 2.0, from->height / 2.0})) {
      const Eigen::Vector3d in_rectified = R.transpose() * *ray;
      shift += camera.pinhole.project(in_rectified) - Eigen::Vector2d(camera.pinhole.cx, camera.pinhole.cy);
      ++count;
    }
  }
  if (count > 0) {
    camera.pinhole.cx -= shift.x() / count;
    camera.pinhole.cy -= shift.y() / count;
  }
  result.maps_[0] = make_maps<Maps>(camera, left, R_left_rectified);
  result.maps_[1] = make_maps<Maps>(camera, right, R_right_rectified);
  return result;
}

void StereoRectification::apply(const Maps& maps, ImageU8& image, ImageU8& scratch) {
  const cv::Mat from(image.height(), image.width(), CV_8U, image.row(0), static_cast<size_t>(image.stride()));
  scratch.resize(maps.fixed.cols, maps.fixed.rows);
  const cv::Mat to(scratch.height(), scratch.width(), CV_8U, scratch.row(0), static_cast<size_t>(scratch.stride()));
  cv::remap(from, to, maps.fixed, maps.fraction, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  image.swap(scratch);
}

}  // namespace covis::io
