// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class OpenLoris : public RecordingTest {
 protected:
  void SetUp() override {
    std::string colour, depths;
    for (int i = 0; i < 3; ++i) {
      const std::string n = "1560000083." + std::to_string(i);
      image("color/" + n + ".png", 10 + i);
      depth("aligned_depth/" + n + "1.png", 1000 * (i + 1));
      colour += n + " color/" + n + ".png\n";
      depths += n + "1 aligned_depth/" + n + "1.png\n";
    }
    write("color.txt", colour);
    write("aligned_depth.txt", depths);
    sensors("[50, 32, 51, 24]");
    write("groundtruth.txt", "#Time px py pz qx qy qz qw\n1560000083.0 1 2 3 0 0 0 1\n");
    write("trans_matrix.yaml", R"(%YAML:1.0
---
trans_matrix:
 - parent_frame: base_link
   child_frame: laser
   matrix: !!opencv-matrix
      rows: 4
      cols: 4
      dt: d
      data: [1, 0, 0, 9, 0, 1, 0, 9, 0, 0, 1, 9, 0, 0, 0, 1]
 - parent_frame: base_link
   child_frame: d400_color_optical_frame
   matrix: !!opencv-matrix
      rows: 4
      cols: 4
      dt: d
      data: [0, 0, 1, 0.25, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 1]
)");
  }
  void sensors(const std::string& intrinsics, const std::string& more = "") const {
    write("sensors.yaml",
          "%YAML:1.0\n---\nd400_accelerometer:\n   rate: 250\nd400_color_optical_frame:\n   width: 64\n   height: 48\n"
          "   intrinsics: !!opencv-matrix\n      rows: 1\n      cols: 4\n      dt: d\n      data: " +
              intrinsics + "\n" + more);
  }
};

TEST_F(OpenLoris, ASideThatIsNoWholeNumberIsRefused) {
  write("sensors.yaml", "d400_color:\n  width: 64.5\n  height: 48\n  intrinsics: [50, 32, 51, 24]\n");
  EXPECT_THAT(open().error().message, HasSubstr("sensors.yaml:2: width must be that of the images, a whole number"));
}

TEST_F(OpenLoris, IsRead) {
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::openloris);
  EXPECT_EQ(s.sensor(), Sensor::rgbd);
  EXPECT_EQ(s.size(), 3);
  EXPECT_EQ(s.camera().pinhole.fx, 50);
  EXPECT_EQ(s.camera().pinhole.fy, 51);
  EXPECT_EQ(s.camera().pinhole.cx, 32);
  EXPECT_EQ(s.camera().pinhole.cy, 24);
  const auto frame = s.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_FLOAT_EQ((*frame)->depth(3, 3), 1);
  EXPECT_EQ((*frame)->stamp, 1560000083'000'000'000);
  const auto truth = load_truth(s);
  ASSERT_TRUE(truth) << truth.error().message;
  EXPECT_TRUE(truth->front().T_wc.t().isApprox(Eigen::Vector3d(1.25, 2, 4), 1e-9)) << "the base's, then the arm";
  EXPECT_TRUE((truth->front().T_wc.R() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX(), 1e-9));
  sensors("[50, 51, 32, 24]");
  EXPECT_EQ((*open())->camera().pinhole.fy, 51) << "in the other order";
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->size(), 3);
}

TEST_F(OpenLoris, SaysWhatItLacks) {
  EXPECT_THAT(open_error({.sensor = Sensor::stereo}),
              AllOf(HasSubstr("fisheye1"), HasSubstr("--sensor must be rgbd or mono")));
  fs::remove(folder / "trans_matrix.yaml");
  EXPECT_THAT((*open())->notes(), ElementsAre(HasSubstr("base_link")));
  const std::string depths = *read_text(folder / "aligned_depth.txt");
  write("aligned_depth.txt", depths.substr(0, depths.find('\n') + 1));
  EXPECT_THAT((*open())->notes(), ElementsAre(HasSubstr("2 of 3 images have no depth"), HasSubstr("base_link")));
  write("aligned_depth.txt", "99 aligned_depth/1560000083.01.png\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("color.txt"), HasSubstr("aligned_depth.txt"), HasSubstr("within 20 ms")));
  fs::remove(folder / "aligned_depth.txt");
  EXPECT_EQ((*open())->sensor(), Sensor::monocular);
  write("color.txt", "2 color/1560000083.1.png\n1 color/1560000083.0.png\n");
  EXPECT_THAT(open_error(), HasSubstr("must rise"));
  write("color.txt", "1 color/none.png\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("color/none.png"), HasSubstr("missing")));
}

TEST_F(OpenLoris, NamesTheFieldOfTheCameraThatIsWrong) {
  sensors("[50, .nan, 51, 24]");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensors.yaml:"), HasSubstr("intrinsics"), HasSubstr("'.nan'")));
  sensors("[-50, 32, 51, 24]");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensors.yaml"), HasSubstr("focal lengths")));
  sensors("[50, 32, 51, 24]", "   distortion_model: fov\n   distortion_coefficients: [0.9, 0, 0, 0, 0]\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("distortion_model 'fov'"), HasSubstr("--camera")));
  sensors("[50, 32, 51, 24]",
          "   distortion_model: inverse_brown_conrady\n   distortion_coefficients: [0.1, 0, 0, 0, 0]\n");
  EXPECT_EQ((*open())->camera().distortion, Distortion::brown_conrady);
  sensors("[50, 32, 51, 24, 0.7]");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("intrinsics has 5 numbers"), HasSubstr("4 of a pinhole camera")));
  sensors("[50, 32, 51, 24]", "   camera_model: omni\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensors.yaml:"), HasSubstr("camera_model 'omni'"), HasSubstr("pinhole")));
  sensors("[50, 32, 51, 24]",
          "   distortion_model: brown_conrady\n   distortion_coefficients: [0.1, 0, 0, 0, 0, 0.2, 0, 0]\n");
  EXPECT_THAT(open_error(), HasSubstr("distortion_coefficients has 8 numbers"));
  write("sensors.yaml", "t265_fisheye1_optical_frame:\n  width: 848\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensors.yaml"), HasSubstr("d400_color")));
  fs::remove(folder / "sensors.yaml");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensors.yaml"), HasSubstr("--camera")));
  camera_yaml("depth_scale: 500\n");
  EXPECT_FLOAT_EQ((*(*open())->next())->depth(0, 0), 2);
}

}  // namespace
}  // namespace covis::io
