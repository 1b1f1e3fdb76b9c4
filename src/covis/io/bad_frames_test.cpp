// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bad_frames.h"

#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(BadFrames, TheFewestStampsAreLeftOut) {
  EXPECT_THAT(longest_rise({1, 2, 3}), ElementsAre(0, 1, 2));
  EXPECT_THAT(longest_rise({1, 900, 2, 3, 4}), ElementsAre(0, 2, 3, 4)) << "one stamp of another time";
  EXPECT_THAT(longest_rise({5, 6, 0, 7}), ElementsAre(0, 1, 3));
  EXPECT_THAT(longest_rise({1, 2, 2, 3}), ElementsAre(0, 1, 3)) << "the first of equal ones";
  EXPECT_THAT(longest_rise({3, 2, 1}), testing::SizeIs(1));
  EXPECT_TRUE(longest_rise({}).empty());
}

class BadFramesOfKitti : public RecordingTest {
 protected:
  static constexpr int kFrames = 100;
  void SetUp() override { kitti(kFrames); }
  void times(int frame, const std::string& stamp) const {
    std::string text;
    for (int i = 0; i < kFrames; ++i) text += (i == frame ? stamp : std::to_string(0.1 * i)) + "\n";
    write("times.txt", text);
  }
};

TEST_F(BadFramesOfKitti, OneInAHundredIsPassedOverAndSaid) {
  fs::remove(folder / "image_1" / "000007.png");
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), kFrames - 1);
  EXPECT_THAT((*opened)->notes(),
              ElementsAre(AllOf(HasSubstr("1 of 100 frames lack a file and are left out"), HasSubstr("000007.png"))));
  fs::remove(folder / "image_1" / "000009.png");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("image_1/000007.png"), HasSubstr("2 of 100"), HasSubstr("--skip-bad")));
  const auto anyway = open({.skip_bad = true});
  ASSERT_TRUE(anyway) << anyway.error().message;
  EXPECT_EQ((*anyway)->size(), kFrames - 2);
}

TEST_F(BadFramesOfKitti, AStampThatDoesNotRiseIsPassedOver) {
  for (const char* stamp : {"0", "99999"}) {
    times(50, stamp);
    const auto opened = open();
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ((*opened)->size(), kFrames - 1);
    EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("1 of 100 frames have stamps that do not rise")));
  }
  times(50, "9223372036.854775807");
  EXPECT_THAT(open_error(), HasSubstr("times.txt:51")) << "so late that differences would overflow";
}

TEST_F(BadFramesOfKitti, ARowOfAListToo) {
  std::string rows;
  for (int i = 0; i < kFrames; ++i) {
    const std::string stamp = std::to_string(1403715273262142976 + (i == 3 ? 0 : i) * 50'000'000L);
    rows += stamp + "," + stamp + ".png\n";
    image("mav0/cam0/data/" + stamp + ".png", 50);
  }
  write("mav0/cam0/data.csv", rows);
  camera_yaml();
  const auto opened = open({.kind = SequenceKind::euroc, .camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), kFrames - 1);
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("data.csv:4")));
}

TEST_F(BadFramesOfKitti, ANameThatNoFileCanHaveIsThatOfAMissingImage) {
  std::string rows;
  for (int i = 0; i < kFrames; ++i) {
    std::string name = std::to_string(i) + ".png";
    if (i == 3) {
      name.insert(0, 300, 'a');
    } else {
      image(name, 50);
    }
    rows += std::to_string(0.1 * i) + " " + name + "\n";
  }
  write("rgb.txt", rows);
  camera_yaml();
  const auto opened = open({.kind = SequenceKind::tum, .sensor = Sensor::monocular});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), kFrames - 1);
  EXPECT_FALSE(is_there(std::string(300, 'a')));
  EXPECT_TRUE(is_there(folder / "rgb.txt"));
  EXPECT_FALSE(is_there(folder / "none.txt"));
}

}  // namespace
}  // namespace covis::io
