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

TEST_F(Sequences, TakesStampsFromNamesInAnyUnit) {
  camera_yaml();
  const auto opened_as = [&](const std::vector<std::string>& names) {
    for (const std::string& name : names) image("images/" + name + ".png", 1);
    auto opened = open();
    EXPECT_TRUE(opened) << opened.error().message;
    fs::remove_all(folder / "images");
    return std::move(*opened);
  };
  for (const std::string digits : {"", "572", "572123"}) {
    const auto opened = opened_as({"1400076021614" + digits, "1400076021664" + digits});
    EXPECT_NEAR(opened->frame_rate(), 20, 1e-6) << digits;
    EXPECT_THAT(opened->notes(), testing::IsEmpty());
  }
  const auto numbered = opened_as({"0000000000", "0000000001"});
  EXPECT_NEAR(numbered->frame_rate(), 30, 1e-5) << "numbers of frames";
  EXPECT_THAT(numbered->notes(), testing::IsEmpty());
  for (const std::string digits : {"", "5", "51", "512", "5123"}) {
    const auto of_device = opened_as({"1" + digits + "40007600000000", "1" + digits + "40007650000000"});
    EXPECT_NEAR(of_device->frame_rate(), 20, 1e-6) << "nanoseconds since it was started, " << digits.size();
    EXPECT_THAT(of_device->notes(), testing::IsEmpty());
  }
  const auto refused = opened_as({"left_1400076021614572", "left_1400076021664572"});
  EXPECT_NEAR(refused->frame_rate(), 30, 1e-5);
  EXPECT_THAT(refused->notes(), testing::ElementsAre(AllOf(HasSubstr("look like stamps"),
                                                           HasSubstr("left_1400076021614572"), HasSubstr("30 Hz"))));
  EXPECT_FALSE(doubt_about_rate(30));
  EXPECT_THAT(*doubt_about_rate(16000), HasSubstr("16000"));
}

TEST_F(Sequences, ReadsImagesOfTheBitsThatTheCameraFileNames) {
  for (const bool stereo : {false, true}) {
    depth("image_0/0.png", 2048);
    if (stereo) depth("image_1/0.png", 1024);
    camera_yaml("bits: 12\nbaseline: 0.1\n");
    const auto opened = open();
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ((*opened)->picture(0)->row(1)[1], 128);
    const auto frame = (*opened)->next();
    EXPECT_EQ((*frame)->image(1, 1), 128);
    EXPECT_EQ((*frame)->right.empty() ? 64 : (*frame)->right(1, 1), 64);
  }
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
