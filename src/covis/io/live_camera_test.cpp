// SPDX-License-Identifier: Apache-2.0
#include "covis/io/live_camera.h"

#include <gmock/gmock.h>

#include <set>

#include "covis/io/test_camera.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using State = LiveStatus::State;

constexpr int kWide = 64, kHigh = 48;

class LiveCameras : public testing::Test {
 protected:
  LiveCameras() : image(kWide, kHigh), small(kWide / 2, kHigh / 2) {}

  LiveCamera& open(SequenceOptions options = {}, std::chrono::milliseconds retry = {}) {
    options.stop = &stop;
    LiveCamera::Setup setup{.name = "0", .camera = {}, .options = options, .retry = retry};
    setup.camera.width = kWide;
    setup.camera.height = kHigh;
    return live.emplace(setup);
  }
  void show(Timestamp stamp) { device.show(stamp, image.view()); }

  ImageU8 image, small;
  TestCamera device;
  std::atomic<int> stop = 0;
  struct Live {
    ~Live() { device.unplug_for_good(); }  // before the LiveCamera ends
    LiveCamera& emplace(const LiveCamera::Setup& setup) {
      camera = std::make_unique<LiveCamera>(device.device(), setup);
      return *camera;
    }
    TestCamera& device;
    std::unique_ptr<LiveCamera> camera = {};
  } live{device};
};

TEST_F(LiveCameras, GiveTheNewestFrameAndCountTheOthers) {
  LiveCamera& camera = open();
  for (int64_t i = 0; i < 10; ++i) show(100 + i);
  device.wait_until_asked(11);
  auto frame = camera.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->index, 9);
  EXPECT_EQ((*frame)->stamp, 109);
  EXPECT_EQ(camera.live().dropped, 9);
  show(200);
  frame = camera.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->index, 10);
  EXPECT_EQ(camera.live().dropped, 9);
  EXPECT_EQ(camera.live().state, State::there);
}

TEST_F(LiveCameras, NeedTheMemoryOfAFewImages) {
  LiveCamera& camera = open();
  std::set<const uint8_t*> memories;
  Frame frame;
  for (int i = 0; i < 50; ++i) {
    show(3 * i);
    show(3 * i + 1);
    device.wait_until_asked(2 * i + 3);
    auto next = camera.next(std::move(frame));
    ASSERT_TRUE(next && *next);
    frame = std::move(**next);
    memories.insert(frame.image.row(0));
  }
  EXPECT_LE(memories.size(), 4u);
  EXPECT_EQ(camera.live().dropped, 50);
}

TEST_F(LiveCameras, AreOpenedAgainAfterTheyWereGone) {
  LiveCamera& camera = open();
  show(1000);
  device.go_away(3);
  show(5);  // the clock of what came back is another
  auto gone = camera.next();
  if (gone) {  // else the later frame has replaced it already
    EXPECT_EQ((*gone)->stamp, 1000);
    gone = camera.next();
  }
  ASSERT_FALSE(gone) << "it is never dropped";
  EXPECT_THAT(gone.error().message, AllOf(HasSubstr("camera 0: it is gone (unplugged)"), HasSubstr("opened again")));
  EXPECT_EQ(camera.live().state, State::gone);
  const auto frame = camera.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->index, 2) << "its going took a number";
  EXPECT_EQ((*frame)->stamp, 1001) << "stamps rise";
  EXPECT_EQ(camera.live().state, State::there);
  device.wait_until_refused(3);
}

TEST_F(LiveCameras, ThatAreOpenedAndShowNothingAreGoneOnce) {
  LiveCamera& camera = open();
  show(1);
  ASSERT_TRUE(camera.next());
  for (int i = 0; i < 3; ++i) device.go_away(0);
  ASSERT_FALSE(camera.next());
  show(2);
  const auto frame = camera.next();
  ASSERT_TRUE(frame && *frame) << frame.error().message;
  EXPECT_EQ((*frame)->index, 4);
}

TEST_F(LiveCameras, OfAnotherSizeEndTheRecordingWithAnErrorThatNamesIt) {
  LiveCamera& camera = open();
  device.show(1, small.view());
  const auto frame = camera.next();
  ASSERT_FALSE(frame);
  EXPECT_THAT(frame.error().message, HasSubstr("camera 0: frame 0 is 32x24, and those before it 64x48"));
  EXPECT_EQ(camera.live().state, State::failed);
  const auto end = camera.next();
  ASSERT_TRUE(end);
  EXPECT_FALSE(*end);
}

TEST_F(LiveCameras, ThatComeBackInAnotherSizeAreNamedBeforeTheirFirstImage) {
  LiveCamera& camera = open();
  show(1);
  ASSERT_TRUE(camera.next());
  device.say_size(32, 24);
  device.go_away(1);
  // That it went may have been taken, or be outdone by what was found when it was back.
  auto next = camera.next();
  if (camera.live().state == State::gone) next = camera.next();
  ASSERT_FALSE(next);
  EXPECT_THAT(next.error().message, HasSubstr("is 32x24, and those before it 64x48"));
  EXPECT_EQ(camera.live().state, State::failed);
}

TEST_F(LiveCameras, ThatAreGoneDoNotKeepAnyoneWhoWantsToEnd) {
  LiveCamera& camera = open({}, std::chrono::hours(1));
  device.go_away(-1);
  ASSERT_FALSE(camera.next());
  stop = 2;
  const auto end = camera.next();
  ASSERT_TRUE(end);
  EXPECT_FALSE(*end);
}

TEST_F(LiveCameras, ReportAnImageThatCannotBeDecodedAndGoOn) {
  LiveCamera& camera = open();
  device.show(1, {});
  const auto bad = camera.next();
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().message, HasSubstr("camera 0: frame 0: it can't be decoded"));
  EXPECT_EQ(camera.live().state, State::there);
  show(2);
  const auto frame = camera.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->index, 1);
}

TEST_F(LiveCameras, ThatLackMemoryEndTheRecordingAndNotTheProcess) {
  LiveCamera& camera = open();
  show(1);
  ASSERT_TRUE(camera.next());
  device.lack_memory();
  const auto failed = camera.next();
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message, AllOf(HasSubstr("camera 0: "), HasSubstr("the memory has run out")));
  EXPECT_EQ(camera.live().state, State::failed);
  const auto end = camera.next();
  EXPECT_TRUE(end && !*end);
}

TEST_F(LiveCameras, GiveAPartOfTheirFrames) {
  LiveCamera& camera = open({.first = 2, .count = 2, .stride = 3});
  EXPECT_NEAR(camera.frame_rate(), 10, 1e-9);
  for (const int64_t wanted : {2, 5}) {
    for (int64_t i = 0; i < 3; ++i) show(wanted + i);
    const auto frame = camera.next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, wanted);
  }
  const auto end = camera.next();
  ASSERT_TRUE(end);
  EXPECT_FALSE(*end);
  EXPECT_FALSE(camera.picture(2));
  EXPECT_FALSE(camera.may_have_colours(2));
}

}  // namespace
}  // namespace covis::io
