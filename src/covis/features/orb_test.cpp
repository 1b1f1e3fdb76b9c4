// SPDX-License-Identifier: Apache-2.0
#include "covis/features/orb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "covis/features/hamming.h"
#include "covis/features/pyramid.h"
#include "tests/opencv_images.h"

namespace covis {
namespace {

// One level, so that both describe the same pixels.
TEST(Orb, OrientationAndDescriptorsAreOpenCvs) {
  int64_t bits = 0, different = 0;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    ImageU8 ours = soft_texture(640, 480, seed);
    const cv::Mat image = as_mat(ours);
    std::vector<cv::KeyPoint> points;
    cv::FAST(image, points, 20, true);
    const auto orb = cv::ORB::create(100000, 1.2f, 1, 31, 0, 2, cv::ORB::FAST_SCORE, 31, 20);
    cv::KeyPointsFilter::runByImageBorder(points, image.size(), 32);
    for (cv::KeyPoint& p : points) {
      p.octave = 0;
      p.size = 31;
      const float angle = orientation(ours.row(static_cast<int>(p.pt.y)) + static_cast<int>(p.pt.x), ours.stride());
      p.angle = angle * 180 / static_cast<float>(CV_PI);
    }
    cv::Mat expected;
    orb->compute(image, points, expected);
    ASSERT_GT(points.size(), 200u);
    ImageU8 blurred;
    GaussianBlur().apply(ours.view(), blurred);
    for (size_t i = 0; i < points.size(); ++i) {
      const int x = static_cast<int>(points[i].pt.x), y = static_cast<int>(points[i].pt.y);
      const Descriptor d =
          describe(blurred.row(y) + x, blurred.stride(), points[i].angle * static_cast<float>(CV_PI) / 180);
      Descriptor e;
      std::memcpy(e.bits.data(), expected.ptr(static_cast<int>(i)), 32);
      different += hamming(d, e);
      bits += 256;
    }
  }
  EXPECT_LT(static_cast<double>(different), 1e-3 * static_cast<double>(bits)) << different << " of " << bits;
}

TEST(Orb, OrientationFollowsTheImage) {
  ImageU8 image = texture(101, 101, 9), turned(101, 101);
  cv::Mat turned_mat = as_mat(turned);
  cv::rotate(as_mat(image), turned_mat, cv::ROTATE_90_CLOCKWISE);
  const float before = orientation(image.row(50) + 50, image.stride());
  const float after = orientation(turned.row(50) + 50, turned.stride());
  EXPECT_NEAR(std::remainder(after - before - CV_PI / 2, 2 * CV_PI), 0, 0.02);
}

}  // namespace
}  // namespace covis
