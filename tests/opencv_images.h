// SPDX-License-Identifier: Apache-2.0
// For the tests of features: images as OpenCV takes them.
#pragma once

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "covis/features/test_images.h"

namespace covis {

inline ImageU8 to_image(const cv::Mat& mat) {
  ImageU8 image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy(mat.ptr(y), mat.ptr(y) + mat.cols, image.row(y));
  return image;
}

// The same pixels, as OpenCV takes them.
inline cv::Mat as_mat(ImageU8& image) {
  return {image.height(), image.width(), CV_8U, image.row(0), static_cast<size_t>(image.stride())};
}

// As soft as a lens makes it: OpenCV rounds its blur's weights otherwise, which a sharper image shows.
inline ImageU8 soft_texture(int width, int height, uint64_t seed) {
  ImageU8 image = texture(width, height, seed);
  cv::Mat mat = as_mat(image);
  cv::GaussianBlur(mat, mat, {5, 5}, 1);
  return image;
}

}  // namespace covis
