// SPDX-License-Identifier: Apache-2.0
#include "covis/io/camera_file.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(Sequences, ReadsTum) {
  tum();
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::tum);
  EXPECT_EQ(s.sensor(), Sensor::rgbd);
  EXPECT_EQ(s.size(), 3);
  EXPECT_NEAR(s.frame_rate(), 10, 1e-6);
  EXPECT_NEAR(s.camera().pinhole.baseline(), 0.08, 1e-9);
  Frame memory;
  for (int i = 0; i < 3; ++i) {
    auto frame = s.next(std::move(memory));
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, i);
    EXPECT_EQ((*frame)->stamp, 1000'000'000'000 + i * 100'000'000);
    EXPECT_EQ((*frame)->image(5, 5), 10 + i);
    EXPECT_FLOAT_EQ((*frame)->depth(5, 5), static_cast<float>(i + 1));
    memory = std::move(**frame);
  }
  EXPECT_FALSE(s.next()->has_value());
  EXPECT_FALSE(s.next()->has_value());
  auto mono = open({.sensor = Sensor::monocular});
  ASSERT_TRUE(mono);
  EXPECT_TRUE((*(*mono)->next())->depth.empty());
}

TEST_F(Sequences, ReadsTumAssociationsAndCalibration) {
  tum();
  fs::remove(folder / "camera.yaml");
  write("associations.txt", "1.5 depth/2.png 1.5 rgb/2.png\n2.5 depth/0.png 2.5 rgb/0.png\n");
  write("calibration.txt", "50 51 32 24 0.1 0.01 0 0\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->camera().pinhole.fy, 51);
  EXPECT_EQ((*opened)->camera().distortion, Distortion::brown_conrady);
  EXPECT_EQ((*opened)->camera().width, kWidth);
  EXPECT_EQ((*(*opened)->next())->image(1, 1), 12);
}

TEST_F(Sequences, PairsImagesAndDepthsByTheNearestStamp) {
  tum(4);
  // 0 and 1 both are near the first depth, 1 nearer; 2 has none within 20 ms; 3 has one.
  write("rgb.txt", "1.000 rgb/0.png\n1.010 rgb/1.png\n2.0 rgb/2.png\n3.0 rgb/3.png\n");
  write("depth.txt", "2.979 depth/2.png\n1.012 depth/1.png\n3.02 depth/3.png\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 2);
  EXPECT_THAT((*opened)->notes(), testing::ElementsAre(HasSubstr("2 of 4 images have no depth")));
  EXPECT_EQ((*opened)->losses(), (*opened)->notes());
  EXPECT_EQ((*(*opened)->next())->image(0, 0), 11);
  const auto last = (*opened)->next();
  EXPECT_EQ((*last)->image(0, 0), 13);
  EXPECT_FLOAT_EQ((*last)->depth(0, 0), 4);
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->size(), 4);
}

TEST_F(Sequences, KnowsTheCamerasOfTheTumDataSet) {
  for (const std::string n : {"1", "2", "3"}) {
    const fs::path inner = "rgbd_dataset_freiburg" + n + "_test";
    image(inner / "rgb/0.png", 9, 640, 480);
    write(inner / "rgb.txt", "1 rgb/0.png\n");
    auto opened = open_sequence((folder / inner).string(), {});
    ASSERT_TRUE(opened) << opened.error().message;
    const auto file = load_camera(fs::path(COVIS_SOURCE_DIR) / "cameras" / ("tum_freiburg" + n + ".yaml"));
    ASSERT_TRUE(file) << file.error().message;
    const Camera &published = (*opened)->camera(), &given = file->camera;
    EXPECT_EQ(published.pinhole.fx, given.pinhole.fx);
    EXPECT_EQ(published.pinhole.fy, given.pinhole.fy);
    EXPECT_EQ(published.pinhole.cx, given.pinhole.cx);
    EXPECT_EQ(published.pinhole.cy, given.pinhole.cy);
    EXPECT_EQ(published.distortion, given.distortion);
    EXPECT_EQ(published.coefficients, given.coefficients);
    EXPECT_EQ(published.pinhole.row_time, given.pinhole.row_time);
    EXPECT_EQ(file->depth_scale, 5000);
  }
}

TEST_F(Sequences, KnowsIclNuimByItsAssociations) {
  const auto number = [&](int i) { return std::to_string(i); };
  std::string rows;
  for (int i = 1; i <= 3; ++i) {
    image("rgb/" + number(i) + ".png", 10 + i, 640, 480);
    depth("depth/" + number(i) + ".png", 10000, 640, 480);
    rows += number(i) + " depth/" + number(i) + ".png " + number(i) + " rgb/" + number(i) + ".png\n";
  }
  write("associations.txt", rows);
  write("traj0.gt.freiburg", "1 0 0 -2.25 0 0 0 1\n2 0 0 -2 0 0 0 1\n3 0 0 -1 0 0 0 1\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_THAT((*opened)->description(), HasSubstr("ICL-NUIM"));
  EXPECT_EQ((*opened)->kind(), SequenceKind::tum);
  EXPECT_EQ((*opened)->camera().pinhole.fx, 481.2);
  EXPECT_EQ((*opened)->camera().pinhole.fy, 480);
  EXPECT_NEAR((*opened)->frame_rate(), 30, 1e-5);
  const auto frame = (*opened)->next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->image(0, 0), 11);
  EXPECT_FLOAT_EQ((*frame)->depth(0, 0), 2);
  const auto truth = load_truth(**opened);
  ASSERT_TRUE(truth) << truth.error().message;
  EXPECT_EQ(truth->front().stamp, (*frame)->stamp);
  write("traj1.gt.freiburg", "1 0 0 nan 0 0 0 1\n");
  opened = open();
  EXPECT_FALSE((*opened)->truth());
  EXPECT_THAT((*opened)->notes(), testing::ElementsAre(HasSubstr("2 files end in .gt.freiburg")));
  fs::remove(folder / "traj0.gt.freiburg");
  EXPECT_THAT(load_truth(**open()).error().message, HasSubstr("traj1.gt.freiburg:1"));
  // Stamps that are none of frames' numbers: another recording, whose camera nobody knows.
  write("associations.txt", "1.5 depth/1.png 1.5 rgb/1.png\n");
  EXPECT_THAT(open_error(), HasSubstr("--camera"));
  write("associations.txt", "1 depth/1.png 1 rgb/1.png\n1 depth/2.png 1 rgb/2.png\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("rgb/2.png"), HasSubstr("must rise")));
}

TEST_F(BadInput, DepthFolderEmpty) {
  tum();
  fs::remove_all(folder / "depth");
  fs::create_directories(folder / "depth");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("depth/0.png"), HasSubstr("missing")));
  write("depth.txt", "# nothing\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("depth.txt"), HasSubstr("no file")));
}

}  // namespace
}  // namespace covis::io
