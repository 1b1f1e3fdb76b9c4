// SPDX-License-Identifier: Apache-2.0
#include "covis/io/camera_file.h"

#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CameraFiles : public RecordingTest {};

TEST_F(CameraFiles, CamerasRoundTrip) {
  CameraFile file;
  file.camera.width = 640;
  file.camera.height = 480;
  file.camera.pinhole = {500.5, 501, 320, 240, 0};
  file.camera.distortion = Distortion::kannala_brandt;
  file.camera.coefficients = {0.1, 0.01, 0.001, 0.0001, 0};
  file.camera.pinhole.depth_noise = {0.001, 0.002};
  file.camera.pinhole.registration = {1.1, 5, -3, 14, 0.5};
  file.camera.pinhole.row_time = -0.02 / 480;
  file.baseline = 0.11;
  file.fps = 30;
  file.bits = 12;
  write("c.yaml", camera_text(file));
  const auto loaded = load_camera(folder / "c.yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->camera.pinhole.fx, 500.5);
  EXPECT_EQ(loaded->camera.coefficients, file.camera.coefficients);
  EXPECT_EQ(loaded->camera.pinhole.depth_noise, file.camera.pinhole.depth_noise);
  const Eigen::Vector2d centre(320, 240), pixel(600, 40);
  const DepthRegistration &now = loaded->camera.pinhole.registration, &before = file.camera.pinhole.registration;
  EXPECT_LT((now.pixel(pixel, centre, 0.7) - before.pixel(pixel, centre, 0.7)).norm(), 1e-9);
  EXPECT_NEAR(loaded->camera.pinhole.baseline(), 0.11, 1e-12);
  EXPECT_EQ(loaded->bits, 12);
  EXPECT_NEAR(loaded->camera.pinhole.row_time, -0.02 / 480, 1e-12);
  for (const auto& entry : fs::directory_iterator(fs::path(COVIS_SOURCE_DIR) / "cameras")) {
    EXPECT_TRUE(load_camera(entry.path())) << entry.path();
  }
}

TEST_F(CameraFiles, CameraFilesThatContradictThemselves) {
  const auto error = [&](const std::string& more) {
    camera_yaml(more);
    const auto loaded = load_camera(folder / "camera.yaml");
    return loaded ? "" : loaded.error().message;
  };
  EXPECT_THAT(error("fx: 60\n"), AllOf(HasSubstr("camera.yaml:7"), HasSubstr("twice")));
  EXPECT_THAT(error("baseline: 0.1\nbf: 5\n"), HasSubstr("not both"));
  EXPECT_THAT(error("model: fisheye\n"), AllOf(HasSubstr("'fisheye'"), HasSubstr("kannala_brandt")));
  EXPECT_THAT(error("model: brown_conrady\n"), HasSubstr("'distortion' is missing"));
  EXPECT_THAT(error("distortion: [0.1, 0, 0, 0]\n"), HasSubstr("model is pinhole"));
  EXPECT_THAT(error("model: kannala_brandt\ndistortion: [0.1, 0, 0, 0, 0]\n"), HasSubstr("must be a list"));
  EXPECT_THAT(error("model: brown_conrady\ndistortion: [0.1, 0, .inf, 0]\n"),
              AllOf(HasSubstr("camera.yaml:8"), HasSubstr("'.inf'")));
  EXPECT_THAT(error("depth_noise: sonar\n"),
              AllOf(HasSubstr("camera.yaml:7"), HasSubstr("kinect, realsense or exact")));
  EXPECT_THAT(error("depth_noise: exact\ndepth_sigma_b: 0.01\n"), HasSubstr("not both"));
  EXPECT_THAT(error("depth_sigma_a: 0\n"), HasSubstr("greater than 0"));
  EXPECT_THAT(error("depth_x: 0.02\n"), AllOf(HasSubstr("camera.yaml:7"), HasSubstr("depth_fx only")));
  EXPECT_THAT(error("depth_fx: 60000\n"), AllOf(HasSubstr("camera.yaml:7"), HasSubstr("from 0.1 to 10 times")));
  EXPECT_THAT(error("readout: 0.5\n"), AllOf(HasSubstr("camera.yaml:7"), HasSubstr("readout"), HasSubstr("0.2")));
  EXPECT_THAT(error("bits: 24\n"), AllOf(HasSubstr("camera.yaml:7"), HasSubstr("bits"), HasSubstr("8")));
  EXPECT_EQ(error("depth_noise: exact\n"), "");
  EXPECT_EQ(load_camera(folder / "camera.yaml")->camera.pinhole.depth_noise, DepthNoise::exact());
  EXPECT_EQ(error("bf: 5\n"), "");
  EXPECT_NEAR(load_camera(folder / "camera.yaml")->baseline, 0.1, 1e-12);
  write("camera.yaml", "- 1\n");
  EXPECT_THAT(load_camera(folder / "camera.yaml").error().message, HasSubstr("must be a map"));
}

}  // namespace
}  // namespace covis::io
