// SPDX-License-Identifier: Apache-2.0
// Recordings that do not show their camera; tests/command_camera_test.cpp has cameras found.
#include "covis/slam/camera_search.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "covis/core/image.h"
#include "covis/core/random.h"
#include "covis/geometry/se3.h"

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

// A camera of 320x240 pixels among squares with a random pattern, which always face it.
class Squares {
 public:
  Squares() {
    Random random(7);
    for (int i = 0; i < 160; ++i) {
      const double z = random.uniform(3, 20);
      Square square{.centre = {z * random.uniform(-1, 1), z * random.uniform(-0.6, 0.6), z}, .side = 0.09 * z};
      for (uint8_t& texel : square.texels) texel = static_cast<uint8_t>(random.uniform(20, 236));
      squares_.push_back(square);
    }
    std::sort(squares_.begin(), squares_.end(),
              [](const Square& a, const Square& b) { return a.centre.z() > b.centre.z(); });
  }

  // `T_wc_at` gives the camera's pose at each of the frames.
  template <class Path>
  Result<FoundCamera> find(int frames, const Path& T_wc_at) const {
    std::vector<ImageU8> images;
    for (int k = 0; k < frames; ++k) images.push_back(seen(T_wc_at(k).inverse()));
    const auto play = [&](const FrameVisitor& visit) -> Result<void> {
      for (int k = 0; k < frames && visit(images[static_cast<size_t>(k)].view(), k * 33'000'000); ++k) {
      }
      return {};
    };
    SystemOptions options;
    options.orb.features = 600;  // enough here, and soon found
    return find_camera(kWidth, kHeight, play, options, [](const std::string&) {});
  }

 private:
  static constexpr int kWidth = 320, kHeight = 240, kTexels = 6;
  static constexpr double kFocal = 260;  // pixels
  struct Square {
    Eigen::Vector3d centre;  // metres
    double side;
    std::array<uint8_t, kTexels * kTexels> texels{};
  };

  ImageU8 seen(const SE3& T_cw) const {
    ImageU8 image(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) std::fill(image.row(y), image.row(y) + kWidth, uint8_t{128});
    for (const Square& square : squares_) {
      const Eigen::Vector3d p_c = T_cw * square.centre;
      if (p_c.z() < 0.5) continue;
      const double side = kFocal * square.side / p_c.z();
      const double left = kFocal * p_c.x() / p_c.z() + 0.5 * (kWidth - 1 - side);
      const double top = kFocal * p_c.y() / p_c.z() + 0.5 * (kHeight - 1 - side);
      const auto texel = [&](double at) { return static_cast<int>(at / side * kTexels); };
      for (int y = std::max(0, static_cast<int>(std::ceil(top))); y < std::min<double>(kHeight, top + side); ++y) {
        for (int x = std::max(0, static_cast<int>(std::ceil(left))); x < std::min<double>(kWidth, left + side); ++x)
          image(x, y) = square.texels[static_cast<size_t>(texel(y - top) * kTexels + texel(x - left))];
      }
    }
    return image;
  }

  std::vector<Square> squares_;
};

SE3 pose(const Eigen::Vector3d& turn, const Eigen::Vector3d& centre) { return {so3_exp(turn), centre}; }

TEST(CameraSearch, AStraightDriveIsRefusedWithTheReason) {
  const auto found = Squares().find(45, [](int k) { return pose({0, 0, 0}, {0, 0, 0.06 * k}); });
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("motion does not tell its focal length"));
  EXPECT_THAT(found.error().message, HasSubstr("it must move sideways and turn, not only go ahead"));
}

TEST(CameraSearch, ATurnInPlaceIsRefusedWithTheReason) {
  const auto found = Squares().find(30, [](int k) { return pose({0, 0.01 * k, 0}, {0, 0, 0}); });
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("must move sideways"));
}

}  // namespace
}  // namespace covis
