// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag.h"
#include "covis/io/files.h"
#include "covis/io/test_bags.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr Timestamp kSecond = 1'000'000'000, kBegin = 1000 * kSecond, kStep = 100'000'000;

// Both kinds of bags, each by its messages' form.
class Bags : public RecordingTest, public testing::WithParamInterface<RosWire> {
 protected:
  void SetUp() override {
    if (GetParam() == RosWire::ros1 && !reads_ros1_bags()) GTEST_SKIP() << "built without rosbag_storage";
  }

  std::string file() const { return (folder / (GetParam() == RosWire::ros1 ? "test.bag" : "test.db3")).string(); }
  Result<std::unique_ptr<Sequence>> open(const SequenceOptions& options = {}) const {
    bag.write(file());
    return open_sequence(file(), options);
  }
  std::string open_error(const SequenceOptions& options = {}) const {
    const auto opened = open(options);
    EXPECT_FALSE(opened);
    return opened ? "" : opened.error().message;
  }
  void add_info(const std::string& topic, double bf = 0) { bag.add(topic, camera_info(bf)); }

  WrittenBag bag{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Each, Bags, testing::Values(RosWire::ros1, RosWire::cdr),
                         [](const auto& wire) { return wire.param == RosWire::ros1 ? "Ros1" : "Ros2"; });

TEST_P(Bags, GiveMonocularFrames) {
  add_info("/camera/camera_info");
  for (int i = 0; i < 4; ++i) bag.add_grey("/camera/image_raw", kBegin + i * kStep, 10 + i);
  auto opened = open({.first = 1});
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::bag);
  EXPECT_EQ(s.sensor(), Sensor::monocular);
  EXPECT_EQ(s.size(), 3);
  EXPECT_NEAR(s.frame_rate(), 10, 1e-6);
  EXPECT_EQ(s.camera().pinhole.fy, 51);
  EXPECT_THAT(s.notes(), IsEmpty());
  EXPECT_THAT(s.description(), AllOf(HasSubstr("/camera/image_raw"), HasSubstr("64x48")));
  EXPECT_EQ(s.picture(3)->row(0)[0], 13) << "in any order";
  EXPECT_EQ(s.picture(1)->row(0)[0], 11);
  EXPECT_FALSE(s.picture(0)) << "it is not read";
  EXPECT_FALSE(s.may_have_colours(1));
  for (int i = 1; i < 4; ++i) {
    const auto frame = s.next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, i);
    EXPECT_EQ((*frame)->stamp, kBegin + i * kStep);
    EXPECT_EQ((*frame)->image(5, 5), 10 + i);
  }
  EXPECT_FALSE(s.next()->has_value());
}

TEST_P(Bags, GiveColourWithRegisteredDepth) {
  add_info("/camera/color/camera_info");
  const std::string red = [] {
    std::string pixels;
    for (int i = 0; i < 64 * 48; ++i) pixels += std::string{'\xc8', '\0', '\0'};
    return pixels;
  }();
  for (int i = 0; i < 3; ++i) {
    const Timestamp stamp = kBegin + i * kStep;
    bag.add_depth("/camera/depth/image_rect_raw", stamp, 9);
    if (i != 1) bag.add_depth("/camera/aligned_depth_to_color/image_raw", stamp + 5'000'000, 1500);
    bag.add_grey("/camera/infra1/image_rect_raw", stamp, 77);
    bag.add_grey("/camera/infra2/image_rect_raw", stamp, 78);
    bag.add_image("/camera/color/image_raw", stamp, "rgb8", red);
  }
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::rgbd);
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("1 of 3 images of /camera/color/image_raw have none"),
                                              HasSubstr("not used: /camera/depth/image_rect_raw, /camera/infra1")));
  EXPECT_THAT((*opened)->losses(), ElementsAre(HasSubstr("1 of 3 images")));
  const auto frame = (*opened)->next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->image(3, 3), 60) << "0.299 of 200";
  EXPECT_FLOAT_EQ((*frame)->depth(3, 3), 1.5f);
  const auto picture = (*opened)->picture(1);
  ASSERT_TRUE(picture && picture->coloured());
  EXPECT_THAT(std::vector<int>(picture->row(2), picture->row(2) + 3), ElementsAre(200, 0, 0));
  EXPECT_TRUE((*opened)->may_have_colours(0));
}

TEST_P(Bags, GiveRectifiedStereoPairs) {
  add_info("/stereo/left/camera_info");
  add_info("/stereo/right/camera_info", 5);
  bag.add_grey("/stereo/left/image_rect", kBegin, 1);
  bag.add_grey("/stereo/right/image_rect", kBegin, 2);
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::stereo);
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.1, 1e-12);
  const auto frame = (*opened)->next();
  EXPECT_EQ((*frame)->image(9, 9), 1);
  EXPECT_EQ((*frame)->right(9, 9), 2);
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->camera().pinhole.bf, 0);
}

TEST_P(Bags, RectifyRawStereoPairs) {
  for (const auto& [side, bf] : {std::pair{"left", 0.0}, std::pair{"right", 5.0}}) {
    RosCameraInfo info = camera_info(bf);
    info.D = {-0.1, 0.01, 0, 0, 0};
    bag.add("/" + std::string(side) + "/camera_info", info);
    bag.add_grey("/" + std::string(side) + "/image_raw", kBegin, 50);
  }
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->camera().distortion, Distortion::none);
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.1, 1e-12);
  const auto frame = (*opened)->next();
  EXPECT_EQ((*frame)->image(32, 24), 50);
  EXPECT_EQ((*opened)->picture(0)->row(24)[32], 50);
}

TEST_P(Bags, TakeTheTopicsThatAreNamed) {
  for (const char* camera : {"a", "b", "c"}) {
    add_info("/" + std::string(camera) + "/camera_info", 5);
    bag.add_grey("/" + std::string(camera) + "/image", kBegin, camera[0]);
  }
  bag.add_depth("/d/image", kBegin, 2000);
  EXPECT_EQ((*(*open({.topics = {.image = "/b/image"}}))->next())->image(0, 0), 'b');
  const auto stereo = open({.topics = {.image = "/b/image", .right = "c/image"}});
  ASSERT_TRUE(stereo) << stereo.error().message;
  EXPECT_EQ((*(*stereo)->next())->right(0, 0), 'c');
  EXPECT_FLOAT_EQ((*(*open({.topics = {.depth = "/d/image"}}))->next())->depth(0, 0), 2);
  EXPECT_THAT(open_error({.topics = {.image = "/e/image"}}),
              AllOf(HasSubstr("/e/image"), HasSubstr("/a/image (sensor_msgs/Image, 1), /b/image")));
  EXPECT_THAT(open_error({.sensor = Sensor::stereo}), HasSubstr("--right-topic"));
}

TEST_P(Bags, LeaveOutStampsThatDoNotRise) {
  add_info("/camera_info");
  for (const int i : {0, 1, 1, 3, 2, 4}) bag.add_grey("/image", kBegin + i * kStep, i);
  for (size_t i = 0; i < bag.messages().size(); ++i) bag.messages()[i].time = static_cast<Timestamp>(i) + 5;
  EXPECT_THAT(open_error(), AllOf(HasSubstr("/image/2: its stamp 1000.100000000 s is not later"),
                                  HasSubstr("2 of 6 messages of /image"), HasSubstr("--skip-bad")));
  auto opened = open({.skip_bad = true});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 4);
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("2 of 6 messages of /image have stamps")));
  EXPECT_EQ((*opened)->losses(), (*opened)->notes());
}

TEST_P(Bags, KeepTheMostFramesWhenAClockIsSetBack) {
  add_info("/camera_info");
  for (int i = 0; i < 100; ++i) bag.add_grey("/image", kBegin + i * kStep + (i < 1 ? 3600 * kSecond : 0), i);
  for (size_t i = 0; i < bag.messages().size(); ++i) bag.messages()[i].time = static_cast<Timestamp>(i) + 5;
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 99) << "not the first one alone";
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("1 of 100 messages of /image have stamps")));
  EXPECT_THAT((*opened)->losses(), IsEmpty());
}

TEST_P(Bags, UseTheBagsTimeWhereAHeaderHasNone) {
  add_info("/camera_info");
  for (int i = 0; i < 2; ++i) {
    bag.add_grey("/image", 0, i);
    bag.messages().back().time = kBegin + i * kStep;
  }
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  (*opened)->next();
  EXPECT_EQ((*(*opened)->next())->stamp, kBegin + kStep);
}

TEST_P(Bags, LeaveOutAMessageWithoutAStampAmongOthersThatHaveOne) {
  add_info("/camera_info");
  for (int i = 0; i < 100; ++i) bag.add_grey("/image", i == 0 ? 0 : (5 + i) * kSecond, i);
  for (size_t i = 0; i < bag.messages().size(); ++i) bag.messages()[i].time = kBegin + static_cast<Timestamp>(i);
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 99);
  EXPECT_EQ((*(*opened)->next())->stamp, 6 * kSecond) << "by the clock of the headers, not the bag's";
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("1 of 100 messages of /image have no stamp")));
}

TEST_P(Bags, PairTopicsByOneClock) {
  for (const char* side : {"left", "right"}) {
    add_info("/" + std::string(side) + "/camera_info", side[0] == 'l' ? 0 : 5);
    for (int i = 0; i < 3; ++i) {
      bag.add_grey("/" + std::string(side) + "/image_rect", side[0] == 'l' ? kSecond + i * kStep : 0, i);
      bag.messages().back().time = kBegin + i * kStep;
    }
  }
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 3);
  EXPECT_EQ((*(*opened)->next())->stamp, kBegin) << "the right images have the bag's alone";
}

TEST_P(Bags, GiveImagesOfTheBitsThatTheCameraFileNames) {
  bag.add_depth("/image", kBegin, 2048);
  camera_yaml("bits: 12\n");
  const auto opened = open({.camera_file = folder / "camera.yaml", .topics = {.image = "/image"}});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*(*opened)->next())->image(1, 1), 128);
}

TEST_P(Bags, SayWhatIsMissing) {
  EXPECT_THAT(open_error(), HasSubstr("there is no image"));
  bag.add("/imu", "sensor_msgs/Imu", camera_info(), 1);
  EXPECT_THAT(open_error(), AllOf(HasSubstr("there is no image"), HasSubstr("/imu (sensor_msgs/Imu)")));
  bag.add_image("/camera/image", kBegin, "nv21", std::string(64 * 48, '1'));
  EXPECT_THAT(open_error(), AllOf(HasSubstr("--camera"), HasSubstr("/camera/camera_info"), HasSubstr("fx:")));
  add_info("/camera/camera_info");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("/camera/image/0"), HasSubstr("'nv21'"), HasSubstr("mono8, 8UC1")));
  camera_yaml("fps: 5\n");
  bag.add_grey("/camera/image", kBegin + kStep, 7);
  EXPECT_TRUE(open({.camera_file = folder / "camera.yaml"}));
  RosCameraInfo uncalibrated = camera_info();
  uncalibrated.K = {};
  std::erase_if(bag.messages(), [](const WrittenMessage& m) { return m.topic == "/camera/camera_info"; });
  bag.add("/camera/camera_info", uncalibrated);
  EXPECT_THAT(open_error(), AllOf(HasSubstr("/camera/camera_info: K"), HasSubstr("not calibrated")));
}

TEST_P(Bags, CutShortAnywhereNameTheFile) {
  add_info("/camera_info");
  for (int i = 0; i < 3; ++i) bag.add_grey("/image", kBegin + i * kStep, i);
  bag.write(file());
  const std::string whole = *read_text(file());
  for (size_t parts = 0; parts < 12; ++parts) {
    write(file(), whole.substr(0, whole.size() * parts / 12));
    const auto opened = open_sequence(file(), {});
    ASSERT_FALSE(opened) << parts;
    EXPECT_THAT(opened.error().message, HasSubstr(file()));
    if (GetParam() == RosWire::ros1 && parts > 0) {
      EXPECT_THAT(opened.error().message, HasSubstr("rosbag reindex"));
    }
  }
}

TEST_F(BadInput, TopicsOfWhatIsNoBag) {
  tum();
  EXPECT_THAT(open_error({.topics = {.image = "/a"}}), HasSubstr("for a bag only"));
}

}  // namespace
}  // namespace covis::io
