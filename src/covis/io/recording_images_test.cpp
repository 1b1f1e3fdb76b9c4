// SPDX-License-Identifier: Apache-2.0
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(Sequences, ReadsAnImageFolderInNaturalOrder) {
  camera_yaml("fps: 20\n");
  for (const int i : {1, 2, 10}) image("frame" + std::to_string(i) + ".png", i);
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->kind(), SequenceKind::images);
  for (const int i : {1, 2, 10}) EXPECT_EQ((*(*opened)->next())->image(0, 0), i);
  EXPECT_NEAR((*opened)->frame_rate(), 20, 1e-6);
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

TEST_F(Sequences, AnImageFolderOpenedUncalibratedHasASizeAlone) {
  image("a.png", 1);
  const auto opened = open_sequence(folder.string(), {.uncalibrated = true});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->camera().width, kWidth);
  EXPECT_EQ((*opened)->camera().pinhole.fx, 0);
  camera_yaml();
  const auto calibrated = open_sequence(folder.string(), {.uncalibrated = true});
  ASSERT_TRUE(calibrated) << calibrated.error().message;
  EXPECT_GT((*calibrated)->camera().pinhole.fx, 0) << "its own calibration is used";
}

}  // namespace
}  // namespace covis::io
