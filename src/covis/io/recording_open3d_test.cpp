// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class Open3d : public RecordingTest {
 protected:
  void record(const std::string& colour = "color", const std::string& ending = ".jpg") const {
    for (int i = 0; i < 3; ++i) {
      const std::string n = "00000" + std::to_string(i);
      image(fs::path(colour) / (n + ending), 10 + i);
      depth("depth/" + n + ".png", 1000 * (i + 1));
    }
  }
  void intrinsic(const std::string& matrix = "[50.0, 0, 0, 0, 51.0, 0, 32.0, 24.0, 1]") const {
    write("camera_intrinsic.json",
          "{\n    \"width\": 64,\n    \"height\": 48,\n    \"intrinsic_matrix\": " + matrix + "\n}");
  }
};

TEST_F(Open3d, IsRead) {
  record();
  intrinsic();
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::open3d);
  EXPECT_EQ(s.sensor(), Sensor::rgbd);
  EXPECT_EQ(s.size(), 3);
  EXPECT_NEAR(s.frame_rate(), 30, 1e-5);
  EXPECT_EQ(s.camera().pinhole.fx, 50);
  EXPECT_EQ(s.camera().pinhole.fy, 51);
  EXPECT_EQ(s.camera().pinhole.cx, 32);
  EXPECT_EQ(s.camera().pinhole.cy, 24);
  const auto frame = s.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->image(3, 3), 10);
  EXPECT_FLOAT_EQ((*frame)->depth(3, 3), 1);
  write("timestamps.txt", "5\n6\n8\n");
  EXPECT_EQ((*(*open())->next())->stamp, 5'000'000'000);
  write("timestamps.txt", "5\n6\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("timestamps.txt"), HasSubstr("2 stamps for 3 images")));
  write("timestamps.txt", "5\n7\n6\n");
  EXPECT_THAT(open_error(), HasSubstr("must rise"));
}

TEST_F(Open3d, AndPlainFoldersWithEqualNames) {
  record("rgb", ".png");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("--camera")));
  camera_yaml("fps: 15\ndepth_scale: 5000\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::rgbd);
  EXPECT_NEAR((*opened)->frame_rate(), 15, 1e-5);
  EXPECT_FLOAT_EQ((*(*opened)->next())->depth(0, 0), 0.2F);
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->size(), 3);
  fs::remove(folder / "depth/000001.png");
  EXPECT_EQ((*open())->size(), 2);
  EXPECT_THAT((*open())->notes(), ElementsAre(HasSubstr("1 of 3 images have no depth image")));
  EXPECT_EQ((*open())->losses(), (*open())->notes());
  depth("depth/other.png", 1);
  for (const char* name : {"000000", "000002"}) fs::remove(folder / "depth" / (std::string(name) + ".png"));
  EXPECT_THAT(open_error({.kind = SequenceKind::open3d}), HasSubstr("depth: no depth image"));
  EXPECT_THAT(open_error({.kind = SequenceKind::open3d, .sensor = Sensor::stereo}),
              HasSubstr("--sensor must be rgbd or mono"));
  fs::remove_all(folder / "depth");
  EXPECT_EQ((*open())->kind(), SequenceKind::images);
  EXPECT_THAT(open_error({.kind = SequenceKind::open3d, .sensor = Sensor::rgbd}), HasSubstr("--sensor mono"));
}

TEST_F(Open3d, IsNotAFolderOfImagesBesideOtherDepth) {
  camera_yaml("fps: 15\n");
  for (const char* name : {"1.01", "1.04", "1.07"}) image("rgb/" + std::string(name) + ".png", 10);
  for (const char* name : {"1.02", "1.05", "1.07"}) depth("depth/" + std::string(name) + ".png", 1000);
  const auto kind = [&] { return (*open())->kind(); };
  EXPECT_EQ(kind(), SequenceKind::images) << "one of three names is that of depth";
  EXPECT_EQ((*open())->sensor(), Sensor::monocular);
  depth("depth/1.04.png", 1000);
  EXPECT_EQ(kind(), SequenceKind::open3d);
  fs::remove_all(folder / "depth");
  for (const char* name : {"1.01", "1.04", "1.07"}) image("depth/" + std::string(name) + ".jpg", 10);
  EXPECT_EQ(kind(), SequenceKind::images) << "pictures of depth";
  fs::rename(folder / "rgb", folder / "color");
  EXPECT_EQ(kind(), SequenceKind::open3d) << "the layout of Open3D";
}

TEST_F(Open3d, NamesTheFieldOfTheCameraThatIsWrong) {
  record();
  intrinsic("[50, 0, 32, 0, 51, 24, 0, 0, 1]");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("fx 0 0 0 fy 0 cx cy 1")));
  intrinsic("[50, 0, 0]");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("'intrinsic_matrix'")));
  intrinsic("[NaN, 0, 0, 0, 51, 0, 32, 24, 1]");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("not JSON")));
  intrinsic("[0, 0, 0, 0, 51, 0, 32, 24, 1]");
  EXPECT_THAT(open_error(), HasSubstr("focal lengths"));
  write("camera_intrinsic.json", "{\"width\": \"64\", \"height\": 48}");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("'width'")));
  write("camera_intrinsic.json", "{\"width\": 64, \"depth\": {\"width\": 1}, \"width\": 65}");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("'width' is given twice")));
}

}  // namespace
}  // namespace covis::io
