// SPDX-License-Identifier: Apache-2.0
// Recordings that do not show their camera; tests/command_camera_test.cpp has cameras found.
#include "covis/slam/camera_search.h"

#include <gmock/gmock.h>

#include <string>

#include "covis/core/image.h"

namespace covis {
namespace {

using testing::HasSubstr;

// Plays so many grey frames of this size; counts how often the recording was played from its beginning.
struct GreyRecording {
  int width, height, frames;
  int played = 0;
  std::function<void()> at_each_frame = [] {};

  Result<FoundCamera> find(const std::atomic<int>* interrupt = nullptr) {
    ImageU8 image(width, height);
    for (int y = 0; y < height; ++y) std::fill(image.row(y), image.row(y) + width, uint8_t{128});
    const auto play = [&](const FrameVisitor& visit) -> Result<void> {
      ++played;
      for (int k = 0; k < frames; ++k) {
        at_each_frame();
        if (!visit(image.view(), k * 33'000'000)) break;
      }
      return {};
    };
    return find_camera(
        width, height, play, SystemOptions(), [](const std::string&) {}, interrupt);
  }
};

TEST(CameraSearch, FramesWithoutAMapAreRefusedWithTheReason) {
  GreyRecording none{320, 240, 0}, few{320, 240, 5}, large{2000, 1500, 2};
  for (GreyRecording* recording : {&none, &few, &large}) {
    const auto found = recording->find();
    ASSERT_FALSE(found);
    EXPECT_THAT(found.error().message, HasSubstr("no map could be made"));
    EXPECT_EQ(recording->played, 4) << "once for each guess";
  }
}

TEST(CameraSearch, ARecordingThatCanNotBePlayedIsItsOwnError) {
  const auto found = find_camera(
      320, 240, [](const FrameVisitor&) -> Result<void> { return fail("video.mp4: it is gone"); }, SystemOptions(),
      [](const std::string&) {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().message, "video.mp4: it is gone");
}

TEST(CameraSearch, EndsSoonWhenItIsInterrupted) {
  std::atomic<int> interrupt = 0;
  GreyRecording recording{320, 240, 1000};
  int frames = 0;
  recording.at_each_frame = [&] { interrupt = ++frames == 3 ? 2 : interrupt.load(); };
  const auto found = recording.find(&interrupt);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("interrupted"));
  EXPECT_EQ(frames, 3);
}

}  // namespace
}  // namespace covis
