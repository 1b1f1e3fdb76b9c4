// SPDX-License-Identifier: Apache-2.0
#include "covis/features/pyramid.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/opencv_images.h"

namespace covis {
namespace {

TEST(Pyramid, ResizeAndBlurAreOpenCvsWithinOneLevel) {
  ImageU8 ours = soft_texture(640, 480, 5);
  const cv::Mat image = as_mat(ours);
  ImageU8 small(533, 400);
  BilinearResizer resizer;
  resizer.resize(ours.view(), small.view());
  cv::Mat expected;
  cv::resize(image, expected, {533, 400}, 0, 0, cv::INTER_LINEAR);
  ImageU8 blurred;
  GaussianBlur().apply(ours.view(), blurred);
  cv::Mat expected_blur;
  cv::GaussianBlur(image, expected_blur, {7, 7}, 2, 2, cv::BORDER_REFLECT_101);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 533; ++x) ASSERT_NEAR(small(x, y), expected.at<uint8_t>(y, x), 1);
  }
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) ASSERT_NEAR(blurred(x, y), expected_blur.at<uint8_t>(y, x), 1);
  }
}

}  // namespace
}  // namespace covis
