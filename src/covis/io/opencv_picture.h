// SPDX-License-Identifier: Apache-2.0
// Pictures out of OpenCV's images, which have blue first.
#pragma once

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "covis/io/images.h"

namespace covis::io {

inline Picture picture_of(const cv::Mat& image) {
  Picture picture{.width = image.cols, .height = image.rows, .channels = image.channels() == 1 ? 1 : 3, .bytes = {}};
  picture.bytes.resize(picture.row_bytes() * static_cast<size_t>(image.rows));
  cv::Mat rgb = image;
  if (image.channels() > 1) cv::cvtColor(image, rgb, image.channels() == 4 ? cv::COLOR_BGRA2RGB : cv::COLOR_BGR2RGB);
  for (int y = 0; y < image.rows; ++y) std::memcpy(picture.row(y), rgb.ptr(y), picture.row_bytes());
  return picture;
}

}  // namespace covis::io
