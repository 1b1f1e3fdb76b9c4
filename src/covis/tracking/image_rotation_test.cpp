// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/image_rotation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "covis/geometry/se3.h"
#include "covis/tracking/test_panorama.h"

namespace covis {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// The light and the sensor of one image.
struct Exposure {
  double gain = 1, offset = 0, noise = 0;
  int blur = 0;  // pixels on either side that are averaged along rows
};

class ImageRotationTest : public testing::Test {
 protected:
  SmallImage see(const Eigen::Matrix3d& R_cw, const Exposure& e = {}) const {
    ImageU8 image(width, height);
    Random random(5);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        double grey = 0;
        for (int k = -e.blur; k <= e.blur; ++k) grey += world.grey(R_cw.transpose() * camera.unproject(x + k, y));
        grey = e.gain * grey / (2 * e.blur + 1) + e.offset + e.noise * random.normal();
        image(x, y) = static_cast<uint8_t>(std::clamp(std::lround(grey), 0l, 255l));
      }
    }
    SmallImage small;
    SmallImageMaker().make(image.view(), small);
    return small;
  }
  // Degrees between the rotation found and the true one; 180 when none is found.
  double error(const Eigen::Matrix3d& R_21, const Exposure& first = {}, const Exposure& second = {}) const {
    const Eigen::Matrix3d R_1w = so3_exp({0.3, -0.2, 0.1});
    const auto found = image_rotation(see(R_1w, first), see(R_21 * R_1w, second), camera);
    return found ? so3_log(*found * R_21.transpose()).norm() / kDegree : 180;
  }

  int width = 160, height = 120;  // enough for the small image
  Pinhole camera{130, 130, 79, 61, 0};
  Panorama world{3};
};

TEST_F(ImageRotationTest, NoTurnIsNone) { EXPECT_LT(error(Eigen::Matrix3d::Identity()), 0.01); }

TEST_F(ImageRotationTest, TurnsAboutEachAxisAreFound) {
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.5, 0.7, 0.5)}) {
    for (const double degrees : {-25, -16, -8, -2, 2, 8, 16, 25}) {
      EXPECT_LT(error(so3_exp(axis.normalized() * degrees * kDegree)), 0.6) << degrees << " about " << axis.transpose();
    }
  }
}

TEST_F(ImageRotationTest, AWideImageIsTurnedByAQuarterOfItsWidth) {
  width = 310, height = 94;
  camera = {180, 180, 155, 43, 0};
  for (const double degrees : {-22, -8, 8, 22}) {
    EXPECT_LT(error(so3_exp({0.01, degrees * kDegree, 0})), 0.3) << degrees;
  }
}

TEST_F(ImageRotationTest, GainAndOffsetAreTakenOff) {
  const Eigen::Matrix3d R = so3_exp({0.05, 0.2, 0.05});
  EXPECT_LT(error(R, {}, {.gain = 0.5}), 0.3);
  EXPECT_LT(error(R, {.gain = 0.6}, {.gain = 0.4, .offset = 60}), 0.3);
}

TEST_F(ImageRotationTest, NoiseAndBlurDoLittle) {
  const Eigen::Matrix3d R = so3_exp({-0.04, 0.25, 0.1});
  EXPECT_LT(error(R, {.noise = 20}, {.noise = 20}), 1);
  EXPECT_LT(error(R, {}, {.blur = 8}), 0.5);
}

TEST_F(ImageRotationTest, TheSameImagesGiveTheSameBits) {
  const SmallImage a = see(Eigen::Matrix3d::Identity()), b = see(so3_exp({0.02, 0.2, 0.05}));
  const auto once = image_rotation(a, b, camera), again = image_rotation(a, b, camera);
  ASSERT_TRUE(once && again);
  EXPECT_EQ(*once, *again);
}

TEST_F(ImageRotationTest, AFlatImageShowsNoTurn) {
  const SmallImage seen = see(Eigen::Matrix3d::Identity());
  const SmallImage flat = see(Eigen::Matrix3d::Identity(), {.gain = 0, .offset = 90});
  const SmallImage noisy = see(Eigen::Matrix3d::Identity(), {.gain = 0, .offset = 90, .noise = 3});
  EXPECT_FALSE(image_rotation(flat, flat, camera));
  EXPECT_FALSE(image_rotation(seen, flat, camera));
  EXPECT_FALSE(image_rotation(flat, seen, camera));
  EXPECT_FALSE(image_rotation(noisy, noisy, camera));
}

TEST_F(ImageRotationTest, WithoutOverlapThereIsNoTurn) {
  EXPECT_FALSE(image_rotation(see(Eigen::Matrix3d::Identity()), see(so3_exp({0, 2.5, 0})), camera));
}

TEST_F(ImageRotationTest, TinyImagesAndImagesOfDifferentSizesAreRefused) {
  const SmallImage seen = see(Eigen::Matrix3d::Identity());
  width = height = 7;
  const SmallImage tiny = see(Eigen::Matrix3d::Identity());
  EXPECT_FALSE(image_rotation(tiny, tiny, camera));
  EXPECT_FALSE(image_rotation(seen, tiny, camera));
  EXPECT_FALSE(image_rotation(SmallImage(), SmallImage(), camera));
}

}  // namespace
}  // namespace covis
