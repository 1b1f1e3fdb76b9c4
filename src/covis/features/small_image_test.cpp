// SPDX-License-Identifier: Apache-2.0
#include "covis/features/small_image.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/features/test_images.h"

namespace covis {
namespace {

SmallImage small_of(const ImageU8& image) {
  SmallImage small;
  SmallImageMaker().make(image.view(), small);
  return small;
}

ImageU8 plain(int width, int height, uint8_t grey) {
  ImageU8 image(width, height);
  for (int y = 0; y < height; ++y) std::fill(image.row(y), image.row(y) + width, grey);
  return image;
}

TEST(SmallImage, HasSome1200PixelsOfTheImagesAspect) {
  const SmallImage vga = small_of(plain(640, 480, 9));
  EXPECT_EQ(vga.width, 40);
  EXPECT_EQ(vga.height, 30);
  const SmallImage street = small_of(plain(1241, 376, 9));
  EXPECT_EQ(street.width, 62);
  EXPECT_EQ(street.height, 18);
  EXPECT_EQ(street.grey.size(), 62u * 18u);
}

TEST(SmallImage, APlainImageKeepsItsGrey) {
  for (const int grey : {0, 1, 100, 255}) {
    const SmallImage small = small_of(plain(333, 250, static_cast<uint8_t>(grey)));
    EXPECT_TRUE(std::all_of(small.grey.begin(), small.grey.end(), [&](int v) { return v == grey; })) << grey;
  }
}

TEST(SmallImage, ImagesOfAnySizeAreTaken) {
  for (const auto& [w, h] : {std::pair{1, 1}, {3, 2}, {40, 30}, {2000, 1}, {1, 2000}, {2000, 1500}}) {
    const SmallImage small = small_of(plain(w, h, 7));
    EXPECT_GE(small.width, 1) << w << " x " << h;
    EXPECT_GE(small.height, 1) << w << " x " << h;
    EXPECT_LE(small.left + small.width * small.block, w);
    EXPECT_LE(small.top + small.height * small.block, h);
  }
}

TEST(SmallImage, ABrightSpotIsWhereTheCameraOfTheSmallImageSeesIt) {
  constexpr int kX = 411, kY = 133;
  ImageU8 image = plain(645, 483, 10);
  for (int y = kY - 8; y <= kY + 8; ++y) std::fill(image.row(y) + kX - 8, image.row(y) + kX + 9, uint8_t{250});
  const SmallImage small = small_of(image);
  double sum = 0, sx = 0, sy = 0;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      const double v = small.grey[static_cast<size_t>(y * small.width + x)] - 10;
      sum += v, sx += v * x, sy += v * y;
    }
  }
  const Pinhole big{500, 510, 320, 240, 0}, camera = small.camera(big);
  const Eigen::Vector3d ray = camera.unproject(sx / sum, sy / sum);
  EXPECT_LT((big.project(ray) - Eigen::Vector2d(kX, kY)).norm(), 1.5);
}

TEST(SmallImage, TheMakerMayBeUsedAgainForAnotherSize) {
  SmallImageMaker maker;
  SmallImage small, again;
  const ImageU8 image = texture(320, 240, 1);
  maker.make(image.view(), small);
  maker.make(plain(700, 500, 3).view(), again);
  maker.make(image.view(), again);
  EXPECT_EQ(small.grey, again.grey);
  EXPECT_EQ(small.width, again.width);
}

}  // namespace
}  // namespace covis
