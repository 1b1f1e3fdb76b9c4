// SPDX-License-Identifier: Apache-2.0
#include "covis/api/rectifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "covis/api/convert.h"

namespace covis {
namespace {

constexpr int kColumns = 320, kRows = 240;

Camera lens() {
  return to_camera({.width = kColumns, .height = kRows, .fx = 250, .fy = 250, .cx = 160, .cy = 120},
                   SensorType::monocular);
}

RightCamera right_of(const Pose& pose) {
  return {.camera = {.width = kColumns, .height = kRows, .fx = 250, .fy = 250, .cx = 160, .cy = 120}, .pose = pose};
}

TEST(Rectifier, APairThatIsRectifiedStaysAsItIs) {
  auto rectifier = Rectifier::create(lens(), right_of({.x = 0.2})).value();
  EXPECT_NEAR(rectifier.camera().pinhole.fx, 250, 1e-9);
  EXPECT_NEAR(rectifier.camera().pinhole.baseline(), 0.2, 1e-9);
  EXPECT_NEAR(rectifier.rectified_left().qw, 1, 1e-12);
  std::vector<uint8_t> pixels(size_t{kColumns} * kRows);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<uint8_t>(i * 7919 % 251);
  const ImageView<const uint8_t> given{pixels.data(), kColumns, kRows, kColumns};
  ImageView<const uint8_t> left = given, right = given;
  rectifier.rectify(left, right);
  ASSERT_NE(left.data, given.data);
  for (int y = 1; y < kRows - 1; ++y) {
    for (int x = 1; x < kColumns - 1; ++x) {
      ASSERT_EQ(left.row(y)[x], given.row(y)[x]) << x << ", " << y;
      ASSERT_EQ(right.row(y)[x], given.row(y)[x]) << x << ", " << y;
    }
  }
}

// A turn about the vertical axis leaves the baseline along x, and the rectified cameras look along it at right angles.
TEST(Rectifier, ATurnOfTheRightCameraLeavesTheLeftOne) {
  const double half = 0.04;  // radians
  const Pose turned{.x = 0.2, .qy = std::sin(half), .qw = std::cos(half)};
  const auto rectifier = Rectifier::create(lens(), right_of(turned)).value();
  const SE3 to_left = to_se3(rectifier.rectified_left());
  EXPECT_NEAR(so3_log(to_left.R()).norm(), 0, 1e-9);
  EXPECT_NEAR(rectifier.camera().pinhole.baseline(), 0.2, 1e-9);
}

TEST(Rectifier, CamerasOneBehindTheOtherAreRefused) {
  EXPECT_FALSE(Rectifier::create(lens(), right_of({.z = 0.2})));
  EXPECT_FALSE(Rectifier::create(lens(), right_of({.x = -0.2})));
  RightCamera small = right_of({.x = 0.2});
  small.camera.width = 300;
  EXPECT_FALSE(Rectifier::create(lens(), small));
}

}  // namespace
}  // namespace covis
