// SPDX-License-Identifier: Apache-2.0
// Every instruction set, and the scalar twins, give the same trajectory to the last bit.
#include <gtest/gtest.h>

#include "covis/core/simd_targets.h"
#include "rendered.h"

namespace covis {
namespace {

class InstructionSets : public ::testing::TestWithParam<Sensor> {
 protected:
  ~InstructionSets() override { use_simd_target("best"); }
};

TEST_P(InstructionSets, GiveTheSameTrajectory) {
  constexpr int kFrames = 25;
  Recording recording(GetParam(), kFrames);
  std::string expected;
  for (const std::string& target : simd_targets()) {
    ASSERT_TRUE(use_simd_target(target)) << target;
    System system(recording.synth.camera(), options_for(GetParam()));
    int tracked = 0;
    for (int i = 0; i < kFrames; ++i)
      tracked += system.process(recording.frame(i)).track.state == TrackingState::tracking;
    system.finish();
    EXPECT_GT(tracked, kFrames / 2) << target;
    const std::string made = bytes(system.online_trajectory()) + bytes(system.trajectory());
    if (expected.empty()) expected = made;
    EXPECT_TRUE(made == expected) << target;
  }
}

TEST(InstructionSetNames, AreKnown) {
  EXPECT_FALSE(use_simd_target("abacus"));
  EXPECT_TRUE(use_simd_target("scalar"));
  EXPECT_FALSE(simd_enabled());
  EXPECT_TRUE(use_simd_target("best"));
  EXPECT_TRUE(simd_enabled());
  EXPECT_EQ(simd_targets().back(), "scalar");
}

INSTANTIATE_TEST_SUITE_P(Sensors, InstructionSets, ::testing::Values(Sensor::stereo));
INSTANTIATE_TEST_SUITE_P(SensorsLong, InstructionSets, ::testing::Values(Sensor::monocular, Sensor::rgbd));

}  // namespace
}  // namespace covis
