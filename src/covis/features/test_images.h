// SPDX-License-Identifier: Apache-2.0
// For the tests of features: textured images, and the same by every instruction set.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "covis/core/image.h"
#include "covis/core/random.h"
#include "covis/features/test_targets.h"

namespace covis {

// Patches of many sizes and grey levels, a little smoothed: corners at every scale.
inline cv::Mat texture(int width, int height, uint64_t seed) {
  Random random(seed);
  cv::Mat image(height, width, CV_8U, cv::Scalar(128));
  for (int k = 0; k < width * height / 400; ++k) {
    const int w = 3 + static_cast<int>(random.below(40)), h = 3 + static_cast<int>(random.below(40));
    const int x = static_cast<int>(random.below(static_cast<uint32_t>(width))),
              y = static_cast<int>(random.below(static_cast<uint32_t>(height)));
    cv::rectangle(image, {x - w, y - h, w, h}, cv::Scalar(random.below(256)), cv::FILLED);
  }
  cv::GaussianBlur(image, image, {3, 3}, 0.8);
  return image;
}

inline ImageU8 to_image(const cv::Mat& mat) {
  ImageU8 image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy(mat.ptr(y), mat.ptr(y) + mat.cols, image.row(y));
  return image;
}

// What `make` returns by the scalar twins; every target must return the same.
template <class Make>
void expect_scalar_twin(Make&& make) {
  set_simd_enabled(false);
  const auto expected = make();
  set_simd_enabled(true);
  for_each_target([&] { EXPECT_TRUE(make() == expected); });
}

}  // namespace covis
