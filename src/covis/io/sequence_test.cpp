// SPDX-License-Identifier: Apache-2.0
// Recordings of every layout.
#include <opencv2/videoio.hpp>

#include "covis/io/camera_file.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Sequences : public RecordingTest {};

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

TEST_F(Sequences, ReadsKitti) {
  kitti();
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->kind(), SequenceKind::kitti);
  EXPECT_EQ((*opened)->sensor(), Sensor::stereo);
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.5, 1e-12);
  const auto frame = (*opened)->next();
  EXPECT_EQ((*frame)->image(0, 0), 20);
  EXPECT_EQ((*frame)->right(0, 0), 30);
  auto part = open({.sensor = Sensor::monocular, .first = 1, .stride = 2});
  ASSERT_TRUE(part);
  EXPECT_EQ((*part)->size(), 1);
  EXPECT_EQ((*(*part)->next())->index, 1);
}

TEST_F(Sequences, ReadsEurocAndRectifies) {
  euroc();
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::euroc);
  EXPECT_EQ(s.sensor(), Sensor::stereo);
  EXPECT_NEAR(s.camera().pinhole.baseline(), 0.1, 1e-9);
  EXPECT_EQ(s.camera().distortion, Distortion::none);
  const auto frame = s.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->stamp, 1403715273262142976);
  EXPECT_EQ((*frame)->image(32, 24), 50);
  EXPECT_EQ((*frame)->right(32, 24), 51);
  // The truth is of the body at (1, 2, 3): the camera is 0.5 m along x from it, turned by a quarter about z.
  const auto truth = load_truth(s);
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->front().T_wc.t().isApprox(Eigen::Vector3d(1.5, 2, 3), 1e-9));
  EXPECT_TRUE((truth->front().T_wc.R() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-9));
  auto mono = open({.sensor = Sensor::monocular});
  ASSERT_TRUE(mono);
  EXPECT_EQ((*mono)->camera().distortion, Distortion::brown_conrady);
  EXPECT_EQ((*mono)->camera().pinhole.bf, 0);
  euroc("equidistant");
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->camera().distortion, Distortion::kannala_brandt);
}

TEST_F(Sequences, PassesOverWhatACopyOfEurocLeavesOut) {
  euroc();
  fs::remove(folder / "mav0/cam0/data/1403715273262142976.png");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 1);
  EXPECT_THAT((*opened)->notes(), testing::ElementsAre(HasSubstr("1 of 2 images")));
  euroc();
  write("mav0/cam1/data.csv", "1403715273262142976,1403715273262142976.png\n");
  EXPECT_THAT((*open())->notes(), testing::ElementsAre(HasSubstr("no right image")));
  euroc();
  for (const char* cam : {"cam0", "cam1"}) fs::remove(folder / "mav0" / cam / "data.csv");
  EXPECT_EQ((*open())->size(), 2);
}

TEST_F(Sequences, ReadsEurocImagesThatAreRectifiedAlready) {
  euroc();
  camera_yaml("baseline: 0.2\n");
  auto opened = open({.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.2, 1e-12);
  EXPECT_EQ((*(*opened)->next())->right(0, 0), 51) << "taken as it is, without the black border of a rectified image";
}

TEST_F(Sequences, ReadsAnImageFolderInNaturalOrder) {
  camera_yaml("fps: 20\n");
  for (const int i : {1, 2, 10}) image("frame" + std::to_string(i) + ".png", i);
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->kind(), SequenceKind::images);
  for (const int i : {1, 2, 10}) EXPECT_EQ((*(*opened)->next())->image(0, 0), i);
  EXPECT_NEAR((*opened)->frame_rate(), 20, 1e-6);
}

TEST_F(Sequences, ReadsAVideo) {
  camera_yaml();
  cv::VideoWriter writer((folder / "video.avi").string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                         {kWidth, kHeight});
  ASSERT_TRUE(writer.isOpened());
  for (int i = 0; i < 5; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(40 * i)));
  writer.release();
  auto opened = open_sequence((folder / "video.avi").string(), {.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  int frames = 0;
  for (auto frame = (*opened)->next(); frame && *frame; frame = (*opened)->next()) {
    EXPECT_NEAR((*frame)->image(20, 20), 40 * frames, 4);
    EXPECT_EQ((*frame)->stamp, frames * 40'000'000);
    ++frames;
  }
  EXPECT_EQ(frames, 5);
}

TEST_F(Sequences, StopsDecodingAtAnyTime) {
  kitti(20);
  for (int k = 0; k < 30; ++k) {
    auto opened = open({.decode_ahead = 1 + k % 4});
    for (int i = 0; i < k % 5; ++i) (*opened)->next();
  }
}

TEST_F(Sequences, MonocularCamerasHaveNoBaseLine) {
  tum();
  camera_yaml("baseline: 0.1\n");
  EXPECT_NEAR((*open())->camera().pinhole.bf, 5, 1e-12);
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->camera().pinhole.bf, 0);
  EXPECT_EQ((*open({.kind = SequenceKind::images}))->sensor(), Sensor::monocular);
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
    EXPECT_EQ(file->depth_scale, 5000);
  }
}

TEST_F(Sequences, ReadsKittiInColourWithItsTruth) {
  for (const char* side : {"2", "3"}) image("sequences/06/image_" + std::string(side) + "/000000.png", 5);
  write("sequences/06/calib.txt",
        "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP2: 50 0 32 3 0 50 24 0 0 0 1 0\nP3: 50 0 32 -22 0 50 24 0 0 0 1 0\n");
  write("sequences/06/times.txt", "0.25\n");
  write("poses/06.txt", "1 0 0 7 0 1 0 8 0 0 1 9\n");
  auto opened = open_sequence((folder / "sequences/06").string(), {});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.5, 1e-12);
  const auto truth = load_truth(**opened);
  ASSERT_TRUE(truth) << truth.error().message;
  EXPECT_EQ(truth->front().stamp, 250'000'000);
  // The poses are of camera 0; camera 2 has it at x = 3 / 50, so is 0.06 m to its left.
  EXPECT_TRUE(truth->front().T_wc.t().isApprox(Eigen::Vector3d(6.94, 8, 9), 1e-9));
}

TEST_F(Sequences, ReadsAPartOfAKittiSequence) {
  kitti(4);
  fs::remove(folder / "image_0/000000.png");
  fs::remove(folder / "image_0/000002.png");
  write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*(*opened)->next())->stamp, 100'000'000);
  EXPECT_EQ((*(*opened)->next())->stamp, 300'000'000);
  EXPECT_EQ(load_truth(**opened)->back().stamp, 100'000'000);
  fs::remove(folder / "times.txt");
  EXPECT_NEAR((*open())->frame_rate(), 10, 1e-9);
}

TEST_F(Sequences, ReadsTheKittiLayoutWithACameraFile) {
  kitti();
  fs::remove(folder / "calib.txt");
  camera_yaml("baseline: 0.3\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::stereo);
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.3, 1e-12);
}

TEST_F(Sequences, TakesStampsFromAListOrFromNames) {
  camera_yaml();
  image("images/1305031102.175304.png", 1);
  image("images/1305031102.211214.png", 2);
  write("images/._1305031102.175304.png", "left behind by a file manager");
  EXPECT_EQ((*(*open())->next())->stamp, 1305031102175304000);
  write("times.txt", "5 first\n6.5 second\n");
  auto listed = open();
  ASSERT_TRUE(listed) << listed.error().message;
  EXPECT_EQ((*(*listed)->next())->stamp, 5'000'000'000);
  EXPECT_EQ((*(*listed)->next())->stamp, 6'500'000'000);
}

TEST_F(Sequences, TakesAPartOfAVideo) {
  camera_yaml("fps: 10\n");
  cv::VideoWriter writer((folder / "video.avi").string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                         {kWidth, kHeight});
  for (int i = 0; i < 9; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(20 * i)));
  writer.release();
  auto opened = open_sequence((folder / "video.avi").string(),
                              {.camera_file = folder / "camera.yaml", .first = 1, .count = 2, .stride = 3});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 2);
  for (const int i : {1, 4}) {
    const auto frame = (*opened)->next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, i);
    EXPECT_EQ((*frame)->stamp, i * 100'000'000);
    EXPECT_NEAR((*frame)->image(20, 20), 20 * i, 4);
  }
  EXPECT_FALSE((*opened)->next()->has_value());
}

TEST_F(Sequences, UsesMemoryOfAnotherRecordingWithoutItsDepth) {
  tum();
  auto rgbd = open();
  Frame memory = std::move(**(*rgbd)->next());
  ASSERT_FALSE(memory.depth.empty());
  auto mono = open({.sensor = Sensor::monocular, .decode_ahead = 1});
  for (int i = 0; i < 3; ++i) {
    auto frame = (*mono)->next(std::move(memory));
    ASSERT_TRUE(frame && *frame);
    EXPECT_TRUE((*frame)->depth.empty());
    memory = std::move(**frame);
  }
}

}  // namespace
}  // namespace covis::io
