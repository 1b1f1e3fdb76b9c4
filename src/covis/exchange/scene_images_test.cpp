// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene_images.h"

#include <algorithm>
#include <cmath>

#include "covis/exchange/test_scene.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

class SceneImages : public testing::Test {
 protected:
  SceneImages() {
    for (const uint32_t serial : {3u, 7u}) {
      SceneView& view = scene.views.emplace_back();
      view.serial = serial;
      view.image = image_name(serial);
    }
    use(camera);
    std::filesystem::create_directories(folder / "kept");
  }
  void use(const Camera& by) { scene.cameras = {{by, by.pinhole, by.pinhole}}; }
  // A picture whose red is its column and whose green is its row.
  io::Picture ramp(int width) const {
    io::Picture picture{.width = width, .height = 60, .channels = 3, .bytes = {}};
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x)
        picture.bytes.insert(picture.bytes.end(), {static_cast<uint8_t>(2 * x), static_cast<uint8_t>(2 * y), 5});
    }
    return picture;
  }

  const TemporaryFolder folder;
  Camera camera{80, 60, {70, 70, 40, 30}, Distortion::brown_conrady, {-0.2, 0.03, 0, 0, 0}};
  Scene scene;
};

TEST_F(SceneImages, ShowEachPlaceWhereThePinholeCameraSeesIt) {
  ASSERT_TRUE(io::write_picture(folder / "kept/000003.png", ramp(80)));
  const auto count = write_images(folder / "kept", folder / "images", scene);
  ASSERT_TRUE(count) << count.error().message;
  EXPECT_EQ(*count, 1u);
  EXPECT_EQ(scene.views[0].image, "000003.png");
  EXPECT_EQ(scene.views[1].image, "") << "none was kept";
  const auto made = io::read_picture(folder / "images/000003.png");
  ASSERT_TRUE(made) << made.error().message;
  for (const int v : {6, 30, 55}) {
    for (const int u : {8, 40, 70}) {
      const Eigen::Vector2d from = *camera.project(camera.pinhole.unproject(u, v));
      EXPECT_NEAR(made->row(v)[3 * u], 2 * from.x(), 1.1);
      EXPECT_NEAR(made->row(v)[3 * u + 1], 2 * from.y(), 1.1);
      EXPECT_EQ(made->row(v)[3 * u + 2], 5);
    }
  }
}

TEST_F(SceneImages, ShowTheSameThroughACentredCameraWithARefinedFocalLength) {
  ASSERT_TRUE(io::write_picture(folder / "kept/000003.png", ramp(80)));
  Pinhole refined = camera.pinhole;
  refined.fx = refined.fy = 77;
  scene.cameras = {{camera, refined, refined}};
  scene = centred(scene);
  ASSERT_TRUE(write_images(folder / "kept", folder / "images", scene));
  const auto made = io::read_picture(folder / "images/000003.png");
  ASSERT_TRUE(made) << made.error().message;
  // A pixel of the undistorted image stays where it is when the focal length is refined.
  const Eigen::Vector2d undistorted(25, 40), taken = *camera.project(camera.pinhole.unproject(25, 40));
  const Eigen::Vector2d at = scene.cameras[0].pinhole.project(refined.unproject(undistorted.x(), undistorted.y()));
  EXPECT_NEAR(made->row(static_cast<int>(std::lround(at.y())))[3 * std::lround(at.x())], 2 * taken.x(), 2.5);
}

TEST_F(SceneImages, AreCopiedWhereThereIsNoDistortion) {
  camera.distortion = Distortion::none;
  use(camera);
  ASSERT_TRUE(io::write_picture(folder / "kept/000007.jpg", ramp(80)));
  ASSERT_EQ(*write_images(folder / "kept", folder / "images", scene), 1u);
  EXPECT_EQ(scene.views[1].image, "000007.jpg");
  EXPECT_EQ(read_file(folder / "images/000007.jpg"), read_file(folder / "kept/000007.jpg"));
}

// A COLMAP and a nerfstudio model in one folder share their images.
TEST_F(SceneImages, ThatAnotherModelNeedsAreNotReplaced) {
  for (const bool copied : {false, true}) {
    if (copied) camera.distortion = Distortion::none;
    use(camera);
    const std::filesystem::path images = folder / (copied ? "copied" : "resampled");
    ASSERT_TRUE(io::write_picture(folder / "kept/000003.png", ramp(80)));
    ASSERT_TRUE(write_images(folder / "kept", images, scene));
    EXPECT_TRUE(write_images(folder / "kept", images, scene, false)) << "they are the same";
    const std::string before = read_file(images / "000003.png");
    io::Picture other = ramp(80);
    std::fill(other.bytes.begin(), other.bytes.end(), uint8_t{9});
    ASSERT_TRUE(io::write_picture(folder / "kept/000003.png", other));
    const auto written = write_images(folder / "kept", images, scene, false);
    ASSERT_FALSE(written);
    EXPECT_THAT(written.error().message, testing::HasSubstr("000003.png: another image is there"));
    EXPECT_EQ(read_file(images / "000003.png"), before);
    EXPECT_TRUE(write_images(folder / "kept", images, scene));
    EXPECT_NE(read_file(images / "000003.png"), before);
  }
}

TEST_F(SceneImages, EachIsThatOfItsOwnCamera) {
  Camera plain = camera;
  plain.distortion = Distortion::none;
  scene.cameras.push_back({plain, plain.pinhole, plain.pinhole});
  scene.views[1].camera = 1;
  for (const char* name : {"kept/000003.png", "kept/000007.png"})
    ASSERT_TRUE(io::write_picture(folder / name, ramp(80)));
  ASSERT_EQ(*write_images(folder / "kept", folder / "images", scene), 2u);
  EXPECT_EQ(read_file(folder / "images/000007.png"), read_file(folder / "kept/000007.png")) << "copied";
  EXPECT_NE(read_file(folder / "images/000003.png"), read_file(folder / "kept/000003.png")) << "undistorted";
}

TEST_F(SceneImages, ThatAreMissingOrDoNotFitAreNamed) {
  const auto error = [&](const std::string& kept) {
    const auto written = write_images(folder / kept, folder / "images", scene);
    return written ? std::string() : written.error().message;
  };
  EXPECT_THAT(error("nowhere"), testing::HasSubstr("--keep-images"));
  EXPECT_THAT(write_images(folder / "kept", folder / "kept", scene).error().message,
              testing::HasSubstr("over those that they are made of"));
  ASSERT_TRUE(io::write_picture(folder / "kept/000003.png", ramp(50)));
  const auto other_size =
      testing::HasSubstr("kept/000003.png: the image is 50x60, the camera of its key frame is 80x60");
  EXPECT_THAT(error("kept"), other_size);
  camera.distortion = Distortion::none;
  use(camera);
  EXPECT_THAT(error("kept"), other_size) << "where they are copied, too";
}

}  // namespace
}  // namespace covis::exchange
