// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/camera_import.h"

#include "covis/exchange/test_scene.h"

namespace covis::exchange {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CameraImports : public testing::Test {
 protected:
  Result<io::ImportedCamera> imported(const std::string& name, const std::string& text) const {
    write_file(folder / name, text);
    return import_camera(folder / name);
  }
  const TemporaryFolder folder;
};

TEST_F(CameraImports, OfColmap) {
  const auto camera = imported("cameras.txt", "# Camera list\n1 RADIAL 640 480 500 320.5 240.5 0.1 -0.02\n");
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(camera->format, "COLMAP camera");
  write_file(folder / "camera.yaml", io::camera_text(camera->file));
  const auto read = io::load_camera(folder / "camera.yaml");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->camera.pinhole.cx, 320) << "COLMAP's first pixel has its middle at 0.5";
  EXPECT_EQ(read->camera.coefficients, (std::array<double, 5>{0.1, -0.02, 0, 0, 0}));
  EXPECT_TRUE(imported("phone.txt", "1 OPENCV_FISHEYE 640 480 300 300 320 240 0 0 0 0\n")) << "known by its content";
}

TEST_F(CameraImports, OfAnUnknownModelOrKindAreOneMessage) {
  EXPECT_THAT(imported("cameras.txt", "1 FULL_OPENCV 640 480 1 2 3 4 5 6 7 8 9 10 11 12\n").error().message,
              AllOf(HasSubstr("cameras.txt:1: camera model 'FULL_OPENCV'"), HasSubstr("OPENCV_FISHEYE")));
  EXPECT_THAT(imported("cameras.txt", "1 PINHOLE 640 480 5 5 320 240\n2 PINHOLE 640 480 5 5 320 240\n").error().message,
              HasSubstr("second camera"));
  EXPECT_THAT(imported("cameras.txt", "1 PINHOLE 640 480 0.5 0.5 320 240\n").error().message,
              HasSubstr("positive focal lengths"));
  EXPECT_THAT(imported("cameras.bin", "x").error().message, HasSubstr("cameras.bin: at the number of cameras"));
  for (const char* name : {"notes.txt", "camera.xml", "a.yaml"}) {
    EXPECT_THAT(
        imported(name, "<camera>: 5 %\n").error().message,
        AllOf(HasSubstr(name), HasSubstr("Kalibr"), HasSubstr("COLMAP"), HasSubstr("Kimera"), HasSubstr("ROS")));
  }
  EXPECT_THAT(import_camera(folder / "none").error().message, HasSubstr("can't be opened"));
}

}  // namespace
}  // namespace covis::exchange
