// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/fuse_memory.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

TEST(FuseMemory, HasWhatWasAddedForThatKeyFrame) {
  FuseMemory memory;
  const KeyFrameId a{3, 1}, b{900, 1};
  EXPECT_FALSE(memory.has(a, {70, 2}));
  memory.add(a, {70, 2});
  EXPECT_TRUE(memory.has(a, {70, 2}));
  EXPECT_FALSE(memory.has(a, {69, 2}));
  EXPECT_FALSE(memory.has(a, {1000000, 2}));
  EXPECT_FALSE(memory.has(b, {70, 2}));
}

TEST(FuseMemory, ForgetsEverythingInsteadOfGrowingWithoutBound) {
  FuseMemory memory;
  constexpr uint32_t kPoints = uint32_t{1} << 24;  // 2 MB a key frame
  for (uint32_t slot = 0; slot < 40; ++slot) memory.add({slot, 1}, {kPoints, 1});
  EXPECT_FALSE(memory.has({0, 1}, {kPoints, 1}));
  EXPECT_TRUE(memory.has({39, 1}, {kPoints, 1}));
}

}  // namespace
}  // namespace covis
