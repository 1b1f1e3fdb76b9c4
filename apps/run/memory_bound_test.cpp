// SPDX-License-Identifier: Apache-2.0
#include "apps/run/memory_bound.h"

#include <gmock/gmock.h>

#include <memory>
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
TEST(MemoryBound, AnArrayOfMoreThanAPageHasPagesOfItsOwn) {
  const auto mapped = [] { return mallinfo2().hblks; };
  const auto before = mapped();
  auto array = std::make_unique<volatile char[]>(5000);
  array[0] = 1;
  EXPECT_EQ(mapped(), before) << "it lies in the common heap";
  return_memory_at_once();
  auto own = std::make_unique<volatile char[]>(5000);
  own[0] = 1;
  EXPECT_EQ(mapped(), before + 1);
  own.reset();
  EXPECT_EQ(mapped(), before) << "its pages are gone with it";
}
#endif

}  // namespace
}  // namespace covis::app
