// SPDX-License-Identifier: Apache-2.0
#include "covis/io/camera_file.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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

  // A camera that is given is no reason to compare with another camera's path.
  CameraFile given;
  given.camera = (*opened)->camera();
  given.baseline = 0.5;
  write_file(folder / "given.yaml", camera_text(given));
  opened = open_sequence((folder / "sequences/06").string(), {.camera_file = folder / "given.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_TRUE(load_truth(**opened)->front().T_wc.t().isApprox(Eigen::Vector3d(6.94, 8, 9), 1e-9));
}

TEST_F(Sequences, ReadsAPartOfAKittiSequence) {
  kitti(4);
  fs::remove(folder / "image_0/000000.png");
  fs::remove(folder / "image_0/000002.png");
  std::string poses;
  for (int k = 0; k < 4; ++k) poses += "1 0 0 " + std::to_string(k) + " 0 1 0 0 0 0 1 0\n";
  write("poses.txt", poses);
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*(*opened)->next())->stamp, 100'000'000);
  EXPECT_EQ((*(*opened)->next())->stamp, 300'000'000);
  ASSERT_TRUE(load_truth(**opened));
  EXPECT_EQ(load_truth(**opened)->back().stamp, 300'000'000);
  fs::remove(folder / "times.txt");
  opened = open();
  EXPECT_NEAR((*opened)->frame_rate(), 10, 1e-9);
  const auto truth = load_truth(**opened);
  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 2u);
  EXPECT_EQ(truth->back().stamp, 100'000'000) << "that of its image, by the counted rate";
  EXPECT_NEAR(truth->back().T_wc.t().x(), 3, 1e-12) << "of the row that its image has the number of";
}

TEST_F(Sequences, ReadsTheKittiLayoutWithACameraFile) {
  kitti();
  fs::remove(folder / "calib.txt");
  camera_yaml("baseline: 0.3\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::stereo);
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.3, 1e-12);
  camera_yaml("baseline: 0.3\nfps: 20\n");
  EXPECT_NEAR((*open())->frame_rate(), 10, 1e-9) << "that of times.txt";
  fs::remove(folder / "times.txt");
  EXPECT_NEAR((*open())->frame_rate(), 20, 1e-9);
}

TEST_F(BadInput, StereoPairWithoutItsRightImage) {
  kitti();
  fs::remove(folder / "image_1/000001.png");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("image_1/000001.png"), HasSubstr("right image"), HasSubstr("missing")));
}

TEST_F(BadInput, StereoPairThatIsNotRectifiedOrHasNoBaseLine) {
  kitti();
  const auto error = [&](const std::string& more) {
    camera_yaml(more);
    return open_error({.camera_file = folder / "camera.yaml"});
  };
  EXPECT_THAT(error(""), AllOf(HasSubstr("camera.yaml"), HasSubstr("baseline")));
  EXPECT_THAT(error("baseline: 0.1\nmodel: brown_conrady\ndistortion: [0.1, 0, 0, 0]\n"),
              AllOf(HasSubstr("camera.yaml"), HasSubstr("rectified")));
  write("calib.txt", "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP1: 50 0 32 25 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("calib.txt"), HasSubstr("not to the right")));
  write("calib.txt", "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP1: 60 0 32 -25 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("calib.txt: P0 and P1: fx is 50 left and 60 right")));
  write("calib.txt", "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP1: 50 0 32 -5e13 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("calib.txt: the baseline in metres: 1e+12")));
  write("calib.txt", "P0: 1e308 0 32 0 0 50 24 0 0 0 1 0\nP1: 1e308 0 32 -25 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("calib.txt: fx, the focal length in pixels: 1e+308")));
}

TEST_F(BadInput, CalibrationOfKittiThatIsNotOfARectifiedCamera) {
  kitti();
  const std::string left = "P0: 50 0 32 0 0 50 24 0 0 0 1 0\n", right = "P1: 50 0 32 -25 0 50 24 0 0 0 1 0\n";
  const auto error = [&](const std::string& row) {
    write("calib.txt", left + row + "\n");
    return open_error();
  };
  EXPECT_THAT(error("P1: 50 5 32 -25 0 50 24 0 0 0 1 0"),
              AllOf(HasSubstr("calib.txt:2: P1 is not that of a rectified camera, 'fx 0 cx x 0 fy cy y 0 0 1 z'"),
                    HasSubstr("number 2 is 5 and must be 0")));
  EXPECT_THAT(error("P1: 50 0 32 -25 1 50 24 0 0 0 1 0"), HasSubstr("number 5 is 1"));
  EXPECT_THAT(error("P1: 50 0 32 -25 0 50 24 0 0.1 0 1 0"), HasSubstr("number 9 is 0.1"));
  EXPECT_THAT(error("P1: 50 0 32 -25 0 50 24 0 0 0 2 0"), HasSubstr("number 11 is 2 and must be 1"));
  EXPECT_THAT(error("P1: 50 0 32 -25 0 50 24 40 0 0 1 0"),
              AllOf(HasSubstr("calib.txt: P0 and P1: numbers 8 and 12"), HasSubstr("0.800000 m apart downwards")));
  EXPECT_THAT(error("P1: 50 0 32 -25 0 50 24 0 0 0 1 5"), HasSubstr("5.000000 m forwards"));
  EXPECT_THAT(error("P1: 50 0 32 -25 0 50 34 0 0 0 1 0"), HasSubstr("cy is 24 left and 34 right"));
  EXPECT_THAT(error("P1: 50 0 32 -25 0 60 24 0 0 0 1 0"), HasSubstr("fy is 50 left and 60 right"));
  EXPECT_THAT(error("P0: 51 0 32 0 0 51 24 0 0 0 1 0"), HasSubstr("calib.txt:2: P0 is given twice"));
  write("calib.txt", "\xef\xbb\xbf" + left + right);
  EXPECT_TRUE(open()) << "behind a byte order mark";
  write("calib.txt", std::string("\xff\xfeP\0"
                                 "0\0",
                                 6));
  EXPECT_THAT(open_error(), HasSubstr("calib.txt: it is in UTF-16"));
}

// Their cameras are some millimetres from where the ideal pair has them; the images here are smaller.
TEST_F(Sequences, ReadsCalibrationsAsTheDataSetHasThem) {
  kitti();
  fs::rename(folder / "image_0", folder / "image_2");
  fs::rename(folder / "image_1", folder / "image_3");
  const std::string f = "7.215377000000e+02 ", c = "32 ", row = "0.000000000000e+00 7.215377000000e+02 24 ";
  write("calib.txt", "P2: " + f + "0.000000000000e+00 " + c + "4.485728000000e+01 " + row +
                         "2.163791000000e-01 0 0 1 2.745884000000e-03\nP3: " + f + "0.000000000000e+00 " + c +
                         "-3.395242000000e+02 " + row + "2.199936000000e+00 0 0 1 2.729905000000e-03\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.5327, 1e-4);
}

}  // namespace
}  // namespace covis::io
