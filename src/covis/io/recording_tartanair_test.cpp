// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "covis/io/files.h"
#include "covis/io/test_npy.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class TartanAir : public RecordingTest {
 protected:
  // Frames of 64x48 with a camera file, or of the data set's size without one.
  void tartan(int frames = 3, int width = kWidth, int height = kHeight) const {
    std::vector<float> metres(static_cast<size_t>(width * height), 2.5F);
    metres[1] = 10000;
    metres[2] = std::numeric_limits<float>::infinity();
    metres[3] = std::numeric_limits<float>::quiet_NaN();
    metres[4] = -1;
    std::string poses;
    for (int i = 0; i < frames; ++i) {
      const std::string n = "00000" + std::to_string(i);
      image("image_left/" + n + "_left.png", 10 + i, width, height);
      image("image_right/" + n + "_right.png", 20 + i, width, height);
      write("depth_left/" + n + "_left_depth.npy", npy_bytes(metres, size_text(height, width)));
      poses += std::to_string(i) + " 2 3 0 0 0 1\n";
    }
    write("pose_left.txt", poses);
    if (width == kWidth) camera_yaml("baseline: 0.25\n");
  }
  static std::string size_text(int rows, int columns) {
    return "(" + std::to_string(rows) + ", " + std::to_string(columns) + ")";
  }
};

TEST_F(TartanAir, IsReadAsItIsPublished) {
  tartan(2, 640, 480);
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::tartanair);
  EXPECT_EQ(s.sensor(), Sensor::rgbd);
  EXPECT_EQ(s.size(), 2);
  EXPECT_NEAR(s.frame_rate(), 10, 1e-9);
  EXPECT_EQ(s.camera().pinhole.fx, 320);
  EXPECT_EQ(s.camera().pinhole.cy, 240);
  EXPECT_EQ(s.camera().pinhole.baseline(), 0.25);
  const auto frame = s.next();
  ASSERT_TRUE(frame && *frame) << frame.error().message;
  EXPECT_EQ((*frame)->image(5, 5), 10);
  EXPECT_EQ((*frame)->depth(0, 0), 2.5F);
  for (int x = 1; x <= 4; ++x) EXPECT_EQ((*frame)->depth(x, 0), 0) << "sky and what is no depth, " << x;
  auto stereo = open({.sensor = Sensor::stereo});
  ASSERT_TRUE(stereo) << stereo.error().message;
  EXPECT_EQ((*(*stereo)->next())->right(5, 5), 20);
  EXPECT_TRUE((*open({.sensor = Sensor::monocular}))->next());
}

TEST_F(TartanAir, TakesTheRichestSensorThereIs) {
  tartan();
  fs::remove_all(folder / "depth_left");
  EXPECT_EQ((*open())->sensor(), Sensor::stereo);
  fs::remove_all(folder / "image_right");
  EXPECT_EQ((*open())->sensor(), Sensor::monocular);
  EXPECT_THAT(open_error({.sensor = Sensor::rgbd}),
              AllOf(HasSubstr("depth_left"), HasSubstr("--sensor stereo or mono")));
  EXPECT_THAT(open_error({.sensor = Sensor::stereo}),
              AllOf(HasSubstr("image_right"), HasSubstr("--sensor rgbd or mono")));
  fs::remove(folder / "pose_left.txt");
  EXPECT_EQ((*open())->kind(), SequenceKind::tartanair) << "recognised by the names of its images";
  EXPECT_FALSE((*open())->truth());
}

TEST_F(TartanAir, TruthIsThatOfTheUsualAxesOfACamera) {
  tartan();
  // A quarter to the right: forward is the world's y.
  write("pose_left.txt", "1 2 3 0 0 0 1\n4 5 6 0 0 0.70710678 0.70710678\n7 8 9 0 0 0 1\n");
  const auto truth = load_truth(**open());
  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 3u);
  EXPECT_EQ((*truth)[1].stamp, 100'000'000);
  EXPECT_TRUE((*truth)[0].T_wc.t().isApprox(Eigen::Vector3d(1, 2, 3)));
  const Eigen::Matrix3d R = (*truth)[0].T_wc.R();
  EXPECT_TRUE((R * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX(), 1e-9)) << "the view is forward";
  EXPECT_TRUE((R * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-9)) << "x is to the right";
  EXPECT_TRUE(((*truth)[1].T_wc.R() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitY(), 1e-7));
  // The names tell the poses of a part of a trajectory.
  fs::remove(folder / "image_left/000000_left.png");
  EXPECT_EQ((*(*open())->next())->stamp, 100'000'000);
}

TEST_F(TartanAir, SecondVersionHasDepthInPictures) {
  const cv::Mat metres(kHeight, kWidth, CV_32F, cv::Scalar(7.25));
  fs::create_directories(folder / "depth_lcam_front");
  cv::imwrite((folder / "depth_lcam_front/000000_lcam_front_depth.png").string(),
              cv::Mat(kHeight, kWidth, CV_8UC4, metres.data));
  image("image_lcam_front/000000_lcam_front.png", 10);
  image("image_rcam_front/000000_rcam_front.png", 20);
  write("pose_lcam_front.txt", "1 2 3 0 0 0 1\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("64x48"), HasSubstr("640x640")));
  camera_yaml("baseline: 0.25\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::rgbd);
  EXPECT_EQ((*(*opened)->next())->depth(9, 9), 7.25F);
  EXPECT_EQ((*(*open({.sensor = Sensor::stereo}))->next())->right(1, 1), 20);
  depth("depth_lcam_front/000000_lcam_front_depth.png", 5000);
  EXPECT_THAT((*open())->next().error().message,
              AllOf(HasSubstr("000000_lcam_front_depth.png"), HasSubstr("four channels")));
}

TEST_F(TartanAir, LeavesFramesOutThatLackAFileWhereThatIsAskedForOrTheyAreFew) {
  tartan();
  fs::remove(folder / "depth_left/000001_left_depth.npy");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("000001_left_depth.npy"), HasSubstr("1 of 3"), HasSubstr("--skip-bad")));
  const auto opened = open({.skip_bad = true});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 2);
  EXPECT_THAT((*opened)->notes(), testing::ElementsAre(HasSubstr("1 of 3 frames lack a file")));
  EXPECT_EQ((*(*opened)->next())->stamp, 0);
  EXPECT_EQ((*(*opened)->next())->stamp, 200'000'000) << "the stamp is that of its own pose";
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->size(), 3);
}

TEST_F(TartanAir, NamesTheFileThatIsWrong) {
  tartan();
  const fs::path first = "depth_left/000000_left_depth.npy";
  const std::string whole = *read_text(folder / first);
  write(first, whole.substr(0, whole.size() / 2));
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr(first.string()), HasSubstr("cut short")));
  write(first, npy_bytes({}, "(48, 64)", "'<f8'"));
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr(first.string()), HasSubstr("descr is '<f8'")));
  write(first, npy_bytes(std::vector<float>(4), "(2, 2)"));
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr(first.string()), HasSubstr("2x2")));
  fs::remove(folder / first);
  EXPECT_THAT(open_error(), AllOf(HasSubstr(first.string()), HasSubstr("missing")));
  fs::remove(folder / "image_right/000001_right.png");
  EXPECT_THAT(open_error({.sensor = Sensor::stereo}), AllOf(HasSubstr("000001_right.png"), HasSubstr("missing")));
  write("pose_left.txt", "0 0 0 0 0 0 1\n0 nan 0 0 0 0 1\n0 0 0 0 0 0 1\n");
  EXPECT_THAT(load_truth(**open({.sensor = Sensor::monocular})).error().message,
              AllOf(HasSubstr("pose_left.txt:2"), HasSubstr("not a finite number")));
  image("image_left/front.png", 1);
  EXPECT_THAT(open_error({.sensor = Sensor::monocular}), AllOf(HasSubstr("front.png"), HasSubstr("_left")));
  fs::remove_all(folder / "image_left");
  EXPECT_THAT(open_error({.kind = SequenceKind::tartanair}), HasSubstr("image_left"));
}

}  // namespace
}  // namespace covis::io
