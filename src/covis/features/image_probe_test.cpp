// SPDX-License-Identifier: Apache-2.0
#include "covis/features/image_probe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "covis/features/frontend.h"
#include "covis/features/test_images.h"

namespace covis {
namespace {

// The features of one image, to be looked for in others.
class ImageProbeTest : public testing::Test {
 protected:
  static constexpr int kWidth = 320, kHeight = 240;

  static Camera camera_of(double k1 = 0) {
    Camera camera;
    camera.width = kWidth;
    camera.height = kHeight;
    camera.pinhole = {250, 250, 159.5, 119.5};
    if (k1 != 0) camera.distortion = Distortion::brown_conrady;
    camera.coefficients[0] = k1;
    return camera;
  }

  static ImageU8 darkened(const ImageU8& image, double gain, int offset) {
    ImageU8 dark(image.width(), image.height());
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) dark(x, y) = static_cast<uint8_t>(gain * image(x, y) + offset);
    }
    return dark;
  }

  explicit ImageProbeTest(double k1 = 0) : camera(camera_of(k1)) {}

  ImageProbe::Expected expected(const Features& f, size_t i) const {
    return {.p_c = 2 * camera.pinhole.unproject(f.x[i], f.y[i]),
            .scale = f.pyramid->scale[f.level[i]],
            .angle = f.angle[i]};
  }
  // The mean distance of the features to what the frontend's last image shows at their places.
  double mean_distance(const Features& f) const {
    double sum = 0;
    int n = 0;
    for (size_t i = 0; i < f.x.size(); ++i) {
      const auto distance = frontend.probe().distance(f.descriptor[i], expected(f, i), camera.pinhole);
      if (!distance) continue;
      sum += *distance;
      ++n;
    }
    EXPECT_GT(n, f.size() / 2);
    return sum / n;
  }

  const Camera camera;
  const ImageU8 image = texture(kWidth, kHeight, 7), other = texture(kWidth, kHeight, 8);
  Frontend frontend{camera, {}, Sensor::monocular};
};

struct BentImageProbeTest : ImageProbeTest {
  BentImageProbeTest() : ImageProbeTest(-0.2) {}
};

TEST_F(ImageProbeTest, KeypointsAreWhereTheyWereFound) {
  const auto features = frontend.monocular(image.view());
  EXPECT_LT(mean_distance(*features), 2);
}

TEST_F(BentImageProbeTest, KeypointsAreFoundThroughTheLens) {
  const auto features = frontend.monocular(image.view());
  EXPECT_LT(mean_distance(*features), 2);
}

TEST_F(ImageProbeTest, ADarkImageLooksAlikeWhereItHasNoCornersLeft) {
  const auto features = frontend.monocular(image.view());
  const ImageU8 dark = darkened(image, 0.06, 20);
  const auto few = frontend.monocular(dark.view());
  ASSERT_LT(few->size(), features->size() / 2);
  EXPECT_LT(mean_distance(*features), 40);
}

TEST_F(ImageProbeTest, AnotherImageDoesNot) {
  const auto features = frontend.monocular(image.view());
  frontend.monocular(other.view());
  EXPECT_GT(mean_distance(*features), 90);
}

TEST_F(ImageProbeTest, PointsThatTheImageDoesNotShowHaveNoDistance) {
  const auto features = frontend.monocular(image.view());
  const auto shown = [&](const Eigen::Vector3d& p_c, float scale) {
    return frontend.probe().distance(features->descriptor[0], {p_c, scale, 0}, camera.pinhole).has_value();
  };
  EXPECT_TRUE(shown({0, 0, 2}, 1));
  EXPECT_FALSE(shown({0, 0, -2}, 1)) << "behind the camera";
  EXPECT_FALSE(shown({2, 0, 2}, 1)) << "beside the image";
  EXPECT_FALSE(shown({0, 0.84, 2}, 1)) << "the pattern does not fit, 15 pixels from the border";
  EXPECT_FALSE(shown({0, 0, 2}, 0.5f)) << "finer than the image";
  EXPECT_FALSE(shown({0, 0, 2}, 20)) << "coarser than the pyramid";
  EXPECT_FALSE(shown({std::nan(""), 0, 2}, 1));
}

TEST_F(ImageProbeTest, ABlackImageShowsNothing) {
  const auto features = frontend.monocular(image.view());
  const ImageU8 black = darkened(image, 0, 0);
  frontend.monocular(black.view());
  EXPECT_FALSE(frontend.probe().distance(features->descriptor[0], expected(*features, 0), camera.pinhole));
}

}  // namespace
}  // namespace covis
