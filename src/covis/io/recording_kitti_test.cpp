// SPDX-License-Identifier: Apache-2.0
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

}  // namespace
}  // namespace covis::io
