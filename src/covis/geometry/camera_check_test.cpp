// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/camera_check.h"

#include <gmock/gmock.h>

#include <limits>

namespace covis {
namespace {

using testing::HasSubstr;

Camera usual() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {525, 525, 320, 240, 52.5};
  return camera;
}

TEST(CameraCheck, NamesTheFigureThatIsOutOfBounds) {
  EXPECT_FALSE(problem_of(usual()));
  const auto said = [](auto&& change) {
    Camera camera = usual();
    change(camera);
    return problem_of(camera).value_or("nothing");
  };
  EXPECT_THAT(said([](Camera& c) { c.width = 15; }), HasSubstr("width: 15 is not right; it must be from 16 to 20000"));
  EXPECT_THAT(said([](Camera& c) { c.height = 20001; }), HasSubstr("height: 20001"));
  EXPECT_THAT(said([](Camera& c) { c.pinhole.fx = 1e308; }), HasSubstr("fx, the focal length in pixels: 1e+308"));
  EXPECT_THAT(said([](Camera& c) { c.pinhole.fy = std::numeric_limits<double>::quiet_NaN(); }), HasSubstr("fy"));
  EXPECT_THAT(said([](Camera& c) { c.pinhole.cx = 640; }), HasSubstr("principal point (640, 240) must lie inside"));
  EXPECT_THAT(said([](Camera& c) { c.pinhole.bf = 525e12; }), HasSubstr("the baseline in metres: 1e+12"));
  EXPECT_THAT(said([](Camera& c) { c.pinhole.bf = -1; }), HasSubstr("the baseline in metres"));
  EXPECT_THAT(said([](Camera& c) { c.coefficients[2] = -1e7; }), HasSubstr("coefficient: -1e+07"));
}

TEST(CameraCheck, BothCamerasOfARectifiedPairAreOne) {
  const Pinhole left = usual().pinhole;
  Pinhole right = left;
  right.cx += 0.1;  // rounding
  EXPECT_FALSE(problem_of_pair(left, right));
  right = left;
  right.fx = 700;
  EXPECT_EQ(*problem_of_pair(left, right),
            "fx is 525 left and 700 right; both images of a rectified pair have the same");
}

TEST(CameraCheck, DoubtsNameWhatCanHardlyBeTracked) {
  EXPECT_TRUE(doubts_about(usual()).empty());
  Camera camera = usual();
  camera.pinhole.fy = 1.9 * camera.pinhole.fx;
  EXPECT_TRUE(doubts_about(camera).empty()) << "a wide film on a narrow one";
  camera.pinhole = {250, 2500, 320, 240, 0};
  EXPECT_THAT(doubts_about(camera), testing::ElementsAre(HasSubstr("250 (fx) and 2500 (fy) pixels mean")));
  camera.height = 40;
  camera.pinhole.fx = camera.pinhole.fy = 1;
  EXPECT_THAT(doubts_about(camera), testing::ElementsAre(HasSubstr("640x40 pixels show too little"),
                                                         HasSubstr("a focal length of 1 pixels")));
  camera = usual();
  camera.pinhole.fx = camera.pinhole.fy = 1e5;
  EXPECT_THAT(doubts_about(camera), testing::ElementsAre(HasSubstr("0.36")));
  camera = usual();
  camera.distortion = Distortion::brown_conrady;
  camera.coefficients = {-0.28, 0.07, 0, 0, 0};
  EXPECT_TRUE(doubts_about(camera).empty()) << "a lens of EuRoC's";
  camera.coefficients = {-3, 0, 0, 0, 0};
  EXPECT_THAT(doubts_about(camera), testing::ElementsAre(HasSubstr("shows two directions at one place, 117 pixels")));
  camera.distortion = Distortion::kannala_brandt;
  camera.coefficients = {0.02, -0.005, 0.001, 0, 0};
  EXPECT_TRUE(doubts_about(camera).empty());
  camera.coefficients = {-5, 0, 0, 0, 0};
  EXPECT_THAT(doubts_about(camera), testing::ElementsAre(HasSubstr("two directions")));
}

}  // namespace
}  // namespace covis
