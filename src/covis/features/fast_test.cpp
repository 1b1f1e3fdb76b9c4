// SPDX-License-Identifier: Apache-2.0
#include "covis/features/fast.h"

#include <gtest/gtest.h>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "tests/opencv_images.h"

namespace covis {
namespace {

using Scored = std::set<std::tuple<int, int, int>>;

Scored by_opencv(const cv::Mat& image, int border, int threshold) {
  std::vector<cv::KeyPoint> points;
  cv::FAST(image, points, threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  Scored found;
  for (const cv::KeyPoint& p : points) {
    const int x = static_cast<int>(p.pt.x), y = static_cast<int>(p.pt.y);
    if (x >= border && y >= border && x < image.cols - border && y < image.rows - border)
      found.emplace(y, x, static_cast<int>(p.response));
  }
  return found;
}

TEST(Fast, CornersAndScoresAreOpenCvs) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    ImageU8 ours = texture(200 + static_cast<int>(seed) * 13, 150, seed);
    cv::Mat image = as_mat(ours);
    if (seed > 3) cv::randu(image, 0, 256);
    for (const int threshold : {1, 7, 20, 60}) {
      FastDetector detector;
      std::vector<Corner> corners;
      detector.detect(ours.view(), 4, 30, threshold, threshold, corners);
      Scored found;
      for (const Corner& c : corners) found.emplace(c.y, c.x, c.score);
      EXPECT_EQ(found, by_opencv(image, 4, threshold)) << "seed " << seed << " threshold " << threshold;
    }
  }
}

TEST(Fast, LowThresholdServesCellsWithoutCornersOnly) {
  cv::Mat image(120, 240, CV_8U, cv::Scalar(100));
  image(cv::Rect(20, 20, 40, 40)) = 200;      // strong corners left
  image(cv::Rect(150, 40, 40, 40)) = 119;     // weak ones right
  image(cv::Rect(45, 90, 20, 20)) = 119;      // weak ones in another cell
  cv::GaussianBlur(image, image, {5, 5}, 1);  // perfect squares have two equal scores at a corner
  FastDetector detector;
  std::vector<Corner> corners;
  detector.detect(to_image(image).view(), 4, 30, 20, 7, corners);
  int strong = 0, weak = 0;
  for (const Corner& c : corners) ++(c.score >= 20 ? strong : weak);
  EXPECT_GE(strong, 4);
  EXPECT_GE(weak, 6);
  detector.detect(to_image(image).view(), 4, 240, 20, 7, corners);  // one cell: the strong ones silence the weak
  for (const Corner& c : corners) EXPECT_GE(c.score, 20);
}

}  // namespace
}  // namespace covis
