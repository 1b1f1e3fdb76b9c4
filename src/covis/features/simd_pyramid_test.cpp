// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"
#include "covis/features/pyramid.h"
#include "tests/opencv_images.h"

namespace covis {
namespace {

std::vector<uint8_t> pixels(const ImageU8& image) {
  std::vector<uint8_t> all;
  for (int y = 0; y < image.height(); ++y) all.insert(all.end(), image.row(y), image.row(y) + image.width());
  return all;
}

TEST(Simd, PyramidAndBlurAreTheScalarOnes) {
  Random random(31);
  for (int trial = 0; trial < 60; ++trial) {
    cv::Mat mat(8 + static_cast<int>(random.below(30)), 5 + static_cast<int>(random.below(150)), CV_8U);
    cv::randu(mat, trial % 4 ? 0 : 255, 256);  // all white too: the greatest sums
    const ImageU8 image = to_image(mat);
    // Exactly the pixels, nothing readable behind them that a sanitizer would let pass.
    const std::vector<uint8_t> bare = pixels(image);
    const ImageView<const uint8_t> view{bare.data(), mat.cols, mat.rows, mat.cols};
    const double factor = random.uniform(1, 2.3);  // beyond what the groups of SIMD span as well
    const int width = std::max(1, static_cast<int>(mat.cols / factor)),
              height = std::max(1, static_cast<int>(mat.rows / factor));
    expect_scalar_twin([&] {
      ImageU8 small(width, height);
      BilinearResizer().resize(view, small.view());
      return pixels(small);
    });
    expect_scalar_twin([&] {
      ImageU8 blurred;
      GaussianBlur().apply(view, blurred);
      return pixels(blurred);
    });
  }
}

}  // namespace
}  // namespace covis
