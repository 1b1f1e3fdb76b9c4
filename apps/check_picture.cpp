// SPDX-License-Identifier: Apache-2.0
#include "check_picture.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "covis/core/atomic_file.h"
#include "covis/features/frontend.h"
#include "covis/io/codecs.h"
#include "covis/io/output_check.h"

namespace covis::app {
namespace {

cv::Mat in_colour(const ImageU8& image) {
  const cv::Mat grey(image.height(), image.width(), CV_8U, const_cast<uint8_t*>(image.row(0)),
                     static_cast<size_t>(image.stride()));
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  return colour;
}

// Colours near depths red and far depths blue.
cv::Scalar depth_colour(double depth, double nearest, double farthest) {
  const double s = std::clamp((1 / depth - 1 / farthest) / (1 / nearest - 1 / farthest), 0.0, 1.0);
  return {255 * (1 - s), 255 * (1 - std::abs(2 * s - 1)), 255 * s};
}

}  // namespace

struct CheckPicture::Impl {
  Impl(const Camera& c, Sensor s) : sensor(s), frontend(c, OrbOptions{}, s), camera(c) {}

  cv::Mat draw(const io::Frame& frame, std::optional<double>& matched);
  cv::Mat draw_stereo(const io::Frame& frame, const Features& features) const;
  cv::Mat draw_depth(const io::Frame& frame) const;

  Sensor sensor;
  Frontend frontend;
  Camera camera;
  std::vector<cv::Mat> rows;
};

cv::Mat CheckPicture::Impl::draw_stereo(const io::Frame& frame, const Features& f) const {
  cv::Mat both;
  cv::hconcat(in_colour(frame.image), in_colour(frame.right), both);
  for (int y = 15; y < both.rows; y += 30) cv::line(both, {0, y}, {both.cols, y}, {0, 160, 0}, 1);
  // The depths at disparities of 100 and 2 pixels.
  const double nearest = camera.pinhole.bf / 100, farthest = camera.pinhole.bf / 2;
  for (int i = 0; i < f.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    if (!f.has_depth(i)) continue;
    const cv::Scalar colour = depth_colour(f.depth[k], nearest, farthest);
    cv::circle(both, cv::Point2f(f.x[k], f.y[k]), 3, colour, 1, cv::LINE_AA);
    cv::circle(both, cv::Point2f(f.u_right[k] + static_cast<float>(frame.image.width()), f.y[k]), 3, colour, 1,
               cv::LINE_AA);
  }
  return both;
}

cv::Mat CheckPicture::Impl::draw_depth(const io::Frame& frame) const {
  cv::Mat image = in_colour(frame.image);
  std::vector<float> depths;
  for (int y = 0; y < frame.depth.height(); y += 8) {
    for (int x = 0; x < frame.depth.width(); x += 8) {
      if (frame.depth(x, y) > 0) depths.push_back(frame.depth(x, y));
    }
  }
  if (depths.empty()) return image;
  std::sort(depths.begin(), depths.end());
  const double nearest = depths[depths.size() / 50],
               farthest = std::max<double>(depths[depths.size() - 1 - depths.size() / 50], nearest * 1.01);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const float d = frame.depth(x, y);
      if (!(d > 0)) continue;
      const cv::Scalar c = depth_colour(d, nearest, farthest);
      cv::Vec3b& pixel = image.at<cv::Vec3b>(y, x);
      for (int k = 0; k < 3; ++k) pixel[k] = cv::saturate_cast<uint8_t>(0.55 * pixel[k] + 0.45 * c[k]);
    }
  }
  return image;
}

cv::Mat CheckPicture::Impl::draw(const io::Frame& frame, std::optional<double>& matched) {
  if (sensor == Sensor::rgbd) {
    cv::Mat both;
    cv::hconcat(in_colour(frame.image), draw_depth(frame), both);
    return both;
  }
  if (sensor == Sensor::stereo) {
    const FeaturesPtr f = frontend.stereo(frame.image.view(), frame.right.view());
    int count = 0;
    for (int i = 0; i < f->size(); ++i) count += f->has_depth(i);
    if (f->size() > 0) matched = static_cast<double>(count) / f->size();
    return draw_stereo(frame, *f);
  }
  const FeaturesPtr f = frontend.monocular(frame.image.view());
  cv::Mat image = in_colour(frame.image);
  for (int i = 0; i < f->size(); ++i) {
    const auto k = static_cast<size_t>(i);
    cv::circle(image, cv::Point2f(f->image_x()[k], f->image_y()[k]),
               static_cast<int>(2 * f->pyramid->scale[f->level[k]]), {0, 255, 0}, 1, cv::LINE_AA);
  }
  return image;
}

CheckPicture::CheckPicture(const Camera& camera, Sensor sensor) : impl_(std::make_unique<Impl>(camera, sensor)) {}
CheckPicture::~CheckPicture() = default;

std::optional<double> CheckPicture::add(const io::Frame& frame) {
  std::optional<double> matched;
  if (static_cast<int>(impl_->rows.size()) >= kFrames) return matched;
  cv::Mat picture = impl_->draw(frame, matched);
  cv::putText(picture, "frame " + std::to_string(frame.index), {8, 22}, cv::FONT_HERSHEY_SIMPLEX, 0.6, {0, 255, 255}, 2,
              cv::LINE_AA);
  impl_->rows.push_back(std::move(picture));
  return matched;
}

Result<void> CheckPicture::write(const std::filesystem::path& file) const {
  if (impl_->rows.empty()) return fail(file.string() + ": there is nothing to draw");
  cv::Mat all;
  cv::vconcat(impl_->rows, all);
  const auto bytes = io::encode_image(".png", all);
  if (!bytes) return fail(file.string() + ": " + bytes.error().message);
  return write_atomically(file, io::marked_picture(*bytes));
}

std::string CheckPicture::caption() const {
  switch (impl_->sensor) {
    case Sensor::stereo:
      return "both images with rows across, matched points coloured by depth (red near)";
    case Sensor::rgbd:
      return "images, and with the depth laid over them (red near)";
    case Sensor::monocular:
      return "images with their keypoints";
  }
  return {};
}

}  // namespace covis::app
