// SPDX-License-Identifier: Apache-2.0
#include "apps/run/memory_bound.h"

#include <gmock/gmock.h>

#include <memory>
#include <vector>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace covis::app {
namespace {

Camera camera_of(int width, int height) { return {width, height, {}, Distortion::none, {}}; }

TEST(MemoryBound, TheMapGetsWhatImagesAndAdjustmentLeave) {
  const auto small = map_megabytes(500, camera_of(640, 480), 0), large = map_megabytes(500, camera_of(3000, 2000), 0);
  ASSERT_TRUE(small && large);
  EXPECT_GT(*small, 100);
  EXPECT_LT(*small, 500 / 3);
  EXPECT_LT(*large, *small - 50);
  EXPECT_LT(map_megabytes(500, camera_of(640, 480), 150'000'000).value(), *small - 40);
}

TEST(MemoryBound, TooLittleIsRefusedWithWhatIsNeeded) {
  const auto refused = map_megabytes(100, camera_of(640, 480), 0);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message,
              testing::HasSubstr("--max-memory 100: images of this size need at least 187 MB"));
  EXPECT_EQ(map_megabytes(187, camera_of(640, 480), 0).value(), 20);
}

#if defined(__GLIBC__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
TEST(MemoryBound, ArraysOfMoreThanAPageHavePagesOfTheirOwn) {
  const auto mapped = [] { return mallinfo2().hblks; };
  const auto mapped_by = [&](std::vector<std::unique_ptr<char[]>>& arrays) {
    const auto before = mapped();
    for (int k = 0; k < 500; ++k) arrays.push_back(std::make_unique<char[]>(5000));
    return mapped() - before;
  };
  std::vector<std::unique_ptr<char[]>> common, own;
  common.reserve(500), own.reserve(500);
  EXPECT_EQ(mapped_by(common), 0u);
  return_memory_at_once();
  EXPECT_GT(mapped_by(own), 400u) << "but for those that fit into what the heap has free";
  const auto all = mapped();
  own.clear();
  EXPECT_LT(mapped() + 400, all) << "their pages go with them";
}
#endif

}  // namespace
}  // namespace covis::app
