// SPDX-License-Identifier: Apache-2.0
#include "covis/features/simd.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"
#include "tests/opencv_images.h"

namespace covis {
namespace {

TEST(Simd, ScoresAndMaximaAreTheScalarOnes) {
  Random random(3);
  for (int trial = 0; trial < 40; ++trial) {
    cv::Mat mat(7, 100 + trial, CV_8U);
    cv::randu(mat, 0, trial % 2 ? 256 : 60);
    const ImageU8 image = to_image(mat);
    const int count = mat.cols - 6, threshold = static_cast<int>(random.below(50));
    expect_scalar_twin([&] {
      std::vector<uint8_t> scores(static_cast<size_t>(count));
      fast_score_row(image.row(3) + 3, image.stride(), count, threshold, scores.data());
      return scores;
    });
    // Few grey levels: equal neighbours, which are no maxima, and rows of zeros.
    cv::randu(mat, 0, trial % 3 == 0 ? 256 : 4);
    if (trial % 5 == 0) mat.colRange(10, 90) = 0;
    const ImageU8 scores = to_image(mat);
    expect_scalar_twin([&] {
      std::vector<uint16_t> columns(static_cast<size_t>(count));
      columns.resize(static_cast<size_t>(
          local_maxima_row(scores.row(1) + 3, scores.row(2) + 3, scores.row(3) + 3, count, columns.data())));
      return columns;
    });
  }
}

}  // namespace
}  // namespace covis
