// SPDX-License-Identifier: Apache-2.0
// Images of 16 bits by a camera that has fewer.
#include "covis/io/images.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using ImageBits = RecordingTest;

TEST_F(ImageBits, AreThoseThatTheCameraFills) {
  ImageReader reader;
  ImageU8 grey;
  cv::Mat image(kHeight, kWidth, CV_16U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.at<uint16_t>(y, x) = static_cast<uint16_t>(x * 4096 / kWidth);
  }
  image.at<uint16_t>(1, 0) = 5000;
  cv::imwrite((folder / "ramp.png").string(), image);
  cv::imwrite((folder / "grey.png").string(), cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(40)));
  ASSERT_TRUE(reader.grey(folder / "ramp.png", grey));
  EXPECT_EQ(grey(63, 0), 15) << "nearly black";
  reader.use_bits(12);
  ASSERT_TRUE(reader.grey(folder / "ramp.png", grey));
  EXPECT_EQ(grey(63, 0), 252);
  EXPECT_EQ(grey(32, 0), 128);
  EXPECT_EQ(grey(0, 1), 255) << "more than the camera can give";
  const auto picture = reader.picture(folder / "ramp.png");
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->row(0)[32], 128);
  EXPECT_TRUE(picture->file.empty()) << "the file shows another picture";
  ASSERT_TRUE(reader.grey(folder / "grey.png", grey));
  EXPECT_EQ(grey(3, 3), 40) << "of 8 bits all are used";
}

}  // namespace
}  // namespace covis::io
