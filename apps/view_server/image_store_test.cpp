// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/image_store.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

namespace covis::view {
namespace {

ImageU8 grey_image(int width, int height, uint8_t value) {
  ImageU8 image(width, height);
  for (int y = 0; y < height; ++y) std::fill_n(image.view().row(y), width, value);
  return image;
}

TEST(ImageStore, ImagesAreMadeSmall) {
  const std::string jpeg = jpeg_of(grey_image(640, 480, 90).view(), 320).value();
  const cv::Mat read = cv::imdecode(std::vector<char>(jpeg.begin(), jpeg.end()), cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(read.cols, 320);
  EXPECT_EQ(read.rows, 240);
  EXPECT_NEAR(read.at<uint8_t>(100, 100), 90, 2);
  EXPECT_EQ(jpeg_of(ImageView<const uint8_t>(), 320), "");
}

TEST(ImageStore, ACopyIsTheImage) {
  const ImageU8 image = grey_image(7, 5, 33);
  const RawImage copy(4, image.view());
  EXPECT_EQ(copy.frame, 4);
  EXPECT_EQ(copy.grey.width(), 7);
  EXPECT_EQ(copy.grey.view()(6, 4), 33);
}

TEST(ImageStore, BeyondItsLimitTheOldestGo) {
  ImageStore store(10);
  store.put(1, "12345");
  store.put(2, "12345");
  store.put(3, "1");
  EXPECT_EQ(store.get(1), std::nullopt);
  EXPECT_EQ(store.get(2), "12345");
  store.put(2, "1");
  store.put(4, "12345678");
  EXPECT_EQ(store.get(2), "1");
  EXPECT_EQ(store.get(9), std::nullopt);
}

}  // namespace
}  // namespace covis::view
