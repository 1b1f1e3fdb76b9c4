// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/shown_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "covis/features/frontend.h"
#include "covis/features/test_images.h"

namespace covis {
namespace {

// One key frame before a wall of boxes, two metres away.
class ShownPointsTest : public testing::Test {
 protected:
  static constexpr int kWidth = 640, kHeight = 480;

  ShownPointsTest() {
    const FeaturesPtr features = frontend.monocular(image.view());
    key_frame = map.add_key_frame(0, 0, SE3(), features->for_key_frame());
    for (uint32_t i = 0; i < static_cast<uint32_t>(features->size()); ++i)
      map.add_point(2 * camera.pinhole.unproject(features->x[i], features->y[i]), key_frame, i);
  }
  // The image with another one in the columns before `until`.
  ImageU8 with_other(int until) const {
    ImageU8 mixed(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      std::copy_n(other.row(y), until, mixed.row(y));
      std::copy(image.row(y) + until, image.row(y) + kWidth, mixed.row(y) + until);
    }
    return mixed;
  }
  // Compares all points, or one in so many, with this image at this pose.
  std::optional<double> compared(const ImageU8& shown, const SE3& T_cw = SE3(), size_t every = 1) {
    frontend.monocular(shown.view());
    ShownPoints points(camera.pinhole, T_cw, bounds);
    const std::vector<MapPointId> all = map.points();
    for (size_t k = 0; k < all.size(); k += every) points.add(map.at(all[k]), map);
    return points.even_share(frontend.probe());
  }

  const Camera camera = camera_for(kWidth, kHeight);
  const ImageBounds bounds{0, 0, kWidth, kHeight};
  const ImageU8 image = texture(kWidth, kHeight, 3), other = texture(kWidth, kHeight, 4);
  Frontend frontend{camera, {}, Sensor::monocular};
  Map map;
  KeyFrameId key_frame;
};

TEST_F(ShownPointsTest, TheSameViewShowsAll) { EXPECT_GT(compared(image).value(), 0.99); }

TEST_F(ShownPointsTest, ACameraThatHasTurnedAroundItsAxisShowsThemTurned) {
  ImageU8 turned(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) turned(x, y) = image(kWidth - 1 - x, kHeight - 1 - y);
  }
  const SE3 half_turn(so3_exp({0, 0, std::numbers::pi}), Eigen::Vector3d::Zero());
  EXPECT_GT(compared(turned, half_turn).value(), 0.9);
}

TEST_F(ShownPointsTest, AThingThatIsThereAndNothingAroundItCountsLessThanItsShare) {
  EXPECT_LT(compared(other).value(), 0.15);
  const double half = compared(with_other(kWidth / 2)).value();
  EXPECT_LT(half, 0.45);
  EXPECT_GT(half, 0.2);
}

TEST_F(ShownPointsTest, AtAnotherPoseNothingAgrees) {
  const SE3 aside(Eigen::Matrix3d::Identity(), {0.1, 0, 0});  // 25 pixels
  EXPECT_LT(compared(image, aside).value(), 0.15);
}

TEST_F(ShownPointsTest, FewPointsSayNothing) {
  EXPECT_FALSE(compared(image, SE3(), map.points().size() / 40));
  const SE3 from_behind(so3_exp({0, std::numbers::pi, 0}), {0, 0, 4});
  EXPECT_FALSE(compared(image, from_behind)) << "nobody was ever there";
}

}  // namespace
}  // namespace covis
