// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/late_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <utility>
#include <vector>

#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

// A camera that went around in 240 frames, 30 a second, and has no pose in some of them.
class LateFramesTest : public testing::Test {
 protected:
  LateFramesTest() : vocabulary_(number_points(scene_)), world_(scene_) { world_.add_key_frames(24, 0, 2); }

  static SE3 T_wc(int64_t frame) {
    const double angle = 2 * std::numbers::pi * (static_cast<double>(frame) + 0.3) / kFrames;
    return SE3(so3_exp({0, angle, 0}), {2 * std::sin(angle), 0, 2 * std::cos(angle)});
  }
  // How many of these frames are located at the end.
  size_t located(std::initializer_list<int64_t> lost) {
    std::vector<PoseOfFrame> known;
    std::vector<UnlocatedFrame> frames;
    for (int64_t k = 0; k < kFrames; ++k) {
      const Timestamp stamp = from_seconds(static_cast<double>(k) / 30);
      if (std::find(lost.begin(), lost.end(), k) == lost.end()) {
        known.push_back({{T_wc(k), 0}, k, stamp});
      } else {
        frames.push_back({k, stamp, scene_.view(T_wc(k).inverse()).features, {}});
      }
    }
    LateFrames late;
    late.keep(std::move(frames));
    return late.locate(Relocaliser(world_.shared, {}, 0, vocabulary_), std::move(known)).size();
  }

 private:
  static constexpr int64_t kFrames = 240;

  PointScene scene_ = PointScene::ring();
  std::shared_ptr<const Vocabulary> vocabulary_;
  SceneMap world_;
};

TEST_F(LateFramesTest, AFewInARowAreLocated) {
  EXPECT_EQ(located({100, 101, 102, 103, 104}), 5u);
  EXPECT_EQ(located({100, 102, 104, 106, 108}), 5u) << "others may lie between them";
}

TEST_F(LateFramesTest, OneAloneMayBeAtALookAlike) {
  EXPECT_EQ(located({100, 101, 102, 103}), 0u);
  EXPECT_EQ(located({10, 50, 90, 130, 170}), 0u) << "those of several gaps are no row";
}

}  // namespace
}  // namespace covis
