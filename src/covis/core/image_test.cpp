// SPDX-License-Identifier: Apache-2.0
#include "covis/core/image.h"

#include <gtest/gtest.h>

#include <cstring>
#include <utility>

namespace covis {
namespace {

TEST(Image, RowsAreAlignedAndReadablePastTheEnd) {
  for (const int width : {1, 63, 64, 65, 641}) {
    ImageU8 image(width, 5);
    EXPECT_EQ(image.width(), width);
    EXPECT_EQ(image.height(), 5);
    EXPECT_GE(image.stride(), width);
    for (int y = 0; y < 5; ++y) {
      EXPECT_EQ(reinterpret_cast<uintptr_t>(image.row(y)) % 64, 0u);
      std::memset(image.row(y), y, static_cast<size_t>(width));
    }
    // The last row's vector may be read whole: the address sanitizer looks.
    uint8_t tail[64];
    std::memcpy(tail, image.row(4) + width, 64);
    for (int y = 0; y < 5; ++y) EXPECT_EQ(image(width - 1, y), y);
  }
}

TEST(Image, MemoryIsKeptWhenItFitsAndGoesWithAMove) {
  ImageF image(100, 80);
  float* const memory = image.row(0);
  image.resize(50, 30);
  EXPECT_EQ(image.row(0), memory);
  image.resize(100, 80);
  EXPECT_EQ(image.row(0), memory);
  image(99, 79) = 3;
  ImageF moved(std::move(image));
  EXPECT_EQ(moved.row(0), memory);
  EXPECT_EQ(moved(99, 79), 3);
  EXPECT_TRUE(image.empty());  // NOLINT(bugprone-use-after-move): left empty
}

TEST(Image, AViewSeesTheOwnersPixels) {
  ImageU8 image(10, 4);
  const ImageView<uint8_t> view = image.view();
  view(9, 3) = 77;
  EXPECT_EQ(image(9, 3), 77);
  const ImageView<const uint8_t> read_only = view;
  EXPECT_EQ(read_only.row(3), image.row(3));
  EXPECT_TRUE(ImageView<uint8_t>().empty());
  EXPECT_TRUE(ImageU8().empty());
  EXPECT_FALSE(view.empty());
}

}  // namespace
}  // namespace covis
