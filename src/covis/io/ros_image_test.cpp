// SPDX-License-Identifier: Apache-2.0
#include "covis/io/ros_image.h"

#include <gmock/gmock.h>

#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>

namespace covis::io {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr char kByte = 'z';  // in gaps between rows

// An image message of the pixels' bytes, with a gap behind each row. `data` keeps the bytes.
RosImage message_of(const char* encoding, const std::vector<std::string>& rows, uint32_t width, std::string& data) {
  data.clear();
  for (const std::string& row : rows) data += row + kByte;
  RosImage message;
  message.width = width;
  message.height = static_cast<uint32_t>(rows.size());
  message.encoding = encoding;
  message.step = static_cast<uint32_t>(rows[0].size() + 1);
  message.data = data;
  return message;
}

std::vector<int> row_of(const ImageU8& image, int y) { return {image.row(y), image.row(y) + image.width()}; }

std::vector<int> grey_of(const RosImage& message, int y = 0) {
  ImageU8 image;
  const auto read = RosImageDecoder().grey(message, image);
  EXPECT_TRUE(read) << read.error().message;
  return read ? row_of(image, y) : std::vector<int>();
}

std::string error_of(const RosImage& message) {
  ImageU8 image;
  const auto read = RosImageDecoder().grey(message, image);
  EXPECT_FALSE(read);
  return read ? "" : read.error().message;
}

std::string encoded(const cv::Mat& image, const char* ending) {
  std::vector<uint8_t> bytes;
  cv::imencode(ending, image, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST(RosImage, GreyOfEachEncoding) {
  std::string data;
  EXPECT_THAT(grey_of(message_of("mono8", {"abc", "def"}, 3, data), 1), ElementsAre('d', 'e', 'f'));
  RosImage words = message_of("mono16", {"0a1b"}, 2, data);
  EXPECT_THAT(grey_of(words), ElementsAre('a', 'b'));
  words.big_endian = true;
  EXPECT_THAT(grey_of(words), ElementsAre('0', '1'));
  const std::string first(1, '\xc8'), zero(1, '\0');
  const auto with = [&](int channels, int at) {
    std::string pixel;
    for (int c = 0; c < channels; ++c) pixel += c == at ? first : zero;
    return pixel;
  };
  EXPECT_THAT(grey_of(message_of("rgb8", {with(3, 0) + with(3, 2)}, 2, data)), ElementsAre(60, 23));
  EXPECT_THAT(grey_of(message_of("bgr8", {with(3, 0) + with(3, 2)}, 2, data)), ElementsAre(23, 60));
  EXPECT_THAT(grey_of(message_of("rgba8", {with(4, 0) + with(4, 2)}, 2, data)), ElementsAre(60, 23));
  EXPECT_THAT(grey_of(message_of("bgra8", {with(4, 0) + with(4, 2)}, 2, data)), ElementsAre(23, 60));
  EXPECT_THAT(grey_of(message_of("yuv422", {"uavb"}, 2, data)), ElementsAre('a', 'b'));
  EXPECT_THAT(grey_of(message_of("yuv422_yuy2", {"aubv"}, 2, data)), ElementsAre('a', 'b'));
}

// Red everywhere: the pattern's pixel of red is bright.
TEST(RosImage, BayerPatternsBeginWhereTheirNamesSay) {
  for (const auto& [name, x0, y0] :
       {std::tuple{"bayer_rggb8", 0, 0}, {"bayer_bggr8", 1, 1}, {"bayer_gbrg8", 0, 1}, {"bayer_grbg8", 1, 0}}) {
    std::vector<std::string> rows(8, std::string(8, '\0'));
    for (size_t y = 0; y < 8; ++y) {
      for (size_t x = 0; x < 8; ++x) {
        if (x % 2 == static_cast<size_t>(x0) && y % 2 == static_cast<size_t>(y0)) rows[y][x] = '\xc8';
      }
    }
    std::string data;
    const RosImage message = message_of(name, rows, 8, data);
    const auto picture = RosImageDecoder().picture(message);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_TRUE(may_have_colours(message));
    EXPECT_THAT(std::vector<int>(picture->row(4) + 12, picture->row(4) + 15), ElementsAre(200, 0, 0)) << name;
    EXPECT_EQ(grey_of(message, 4)[4], 60) << name;
  }
}

TEST(RosImage, GreyByTheBitsThatTheCameraFills) {
  RosImageDecoder decoder;
  decoder.use_bits(12);
  ImageU8 image;
  std::string data;
  RosImage words = message_of("mono16", {std::string("\x00\x08\xf0\x0f\x00\x10", 6)}, 3, data);
  ASSERT_TRUE(decoder.grey(words, image));
  EXPECT_THAT(row_of(image, 0), ElementsAre(128, 255, 255));
  words = message_of("mono16", {std::string("\x08\x00\x0f\xf0\x00\x10", 6)}, 3, data);
  words.big_endian = true;
  ASSERT_TRUE(decoder.grey(words, image));
  EXPECT_THAT(row_of(image, 0), ElementsAre(128, 255, 1));
  EXPECT_EQ(decoder.picture(words)->row(0)[0], 128);
  const std::string png = encoded(cv::Mat(2, 2, CV_16UC1, cv::Scalar(2048)), ".png");
  RosCompressedImage compressed;
  compressed.format = "mono16; png compressed";
  compressed.data = png;
  ASSERT_TRUE(decoder.grey(compressed, image));
  EXPECT_EQ(image(1, 1), 128);
  EXPECT_EQ(decoder.picture(compressed)->row(1)[1], 128);
}

TEST(RosImage, DepthInMetres) {
  ImageF depth;
  std::string data;
  RosImage words = message_of("16UC1", {std::string("\xdc\x05\x00\x00", 4)}, 2, data);
  ASSERT_TRUE(RosImageDecoder().depth(words, 1000, depth));
  EXPECT_FLOAT_EQ(depth(0, 0), 1.5f);
  EXPECT_EQ(depth(1, 0), 0);
  words = message_of("16UC1", {std::string("\x05\xdc\x00\x00", 4)}, 2, data);
  words.big_endian = true;
  ASSERT_TRUE(RosImageDecoder().depth(words, 1000, depth));
  EXPECT_FLOAT_EQ(depth(0, 0), 1.5f);
  const float values[] = {2.5f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1};
  std::string bytes(sizeof values, '\0');
  std::memcpy(bytes.data(), values, sizeof values);
  ASSERT_TRUE(RosImageDecoder().depth(message_of("32FC1", {bytes, bytes}, 4, data), 1000, depth));
  EXPECT_EQ(depth(0, 1), 2.5f);
  for (const int x : {1, 2, 3}) EXPECT_EQ(depth(x, 1), 0);
  const auto refused = RosImageDecoder().depth(message_of("rgb8", {"abc"}, 1, data), 1000, depth);
  EXPECT_THAT(refused.error().message, AllOf(HasSubstr("'rgb8'"), HasSubstr("16UC1, mono16, 32FC1")));
}

TEST(RosImage, CompressedImages) {
  ImageU8 grey;
  for (const char* ending : {".png", ".jpg"}) {
    const std::string file = encoded(cv::Mat(8, 16, CV_8UC3, cv::Scalar(0, 0, 200)), ending);
    RosCompressedImage message;
    message.format = "rgb8; jpeg compressed bgr8";
    message.data = file;
    ASSERT_TRUE(RosImageDecoder().grey(message, grey));
    EXPECT_NEAR(grey(9, 5), 60, 1);
    const auto picture = RosImageDecoder().picture(message);
    ASSERT_TRUE(picture && picture->coloured());
    EXPECT_NEAR(picture->row(0)[0], 200, 2);
    message.data = message.data.substr(0, file.size() / 2);
    EXPECT_THAT(RosImageDecoder().grey(message, grey).error().message, HasSubstr("data: the image file is cut short"));
  }
}

// As image_transport's plug-in compresses what a Bayer camera takes.
TEST(RosImage, CompressedBayerPatternsAreColours) {
  cv::Mat mosaic(8, 8, CV_8UC1, cv::Scalar(0));
  for (int y = 0; y < 8; y += 2) {
    for (int x = 0; x < 8; x += 2) mosaic.at<uint8_t>(y, x) = 200;
  }
  const std::string file = encoded(mosaic, ".png");
  RosCompressedImage message;
  message.format = "bayer_rggb8; png compressed ";
  message.data = file;
  ImageU8 grey;
  const auto read = RosImageDecoder().grey(message, grey);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(grey(4, 4), 60);
  EXPECT_EQ(grey(5, 5), 60);
  const auto picture = RosImageDecoder().picture(message);
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_THAT(std::vector<int>(picture->row(4) + 12, picture->row(4) + 15), ElementsAre(200, 0, 0));
  cv::Mat wide;
  mosaic.convertTo(wide, CV_16UC1, 256);
  const std::string of_16_bits = encoded(wide, ".png");
  message.format = "bayer_rggb16; png compressed ";
  message.data = of_16_bits;
  ASSERT_TRUE(RosImageDecoder().grey(message, grey));
  EXPECT_EQ(grey(5, 5), 60);
  ASSERT_TRUE(RosImageDecoder().picture(message));
  EXPECT_TRUE(RosImageDecoder().picture(message)->coloured());
  message.format = "bayer_odd; png compressed ";
  EXPECT_THAT(RosImageDecoder().grey(message, grey).error().message, HasSubstr("encoding 'bayer_odd'"));
  const std::string colours = encoded(cv::Mat(8, 16, CV_8UC3, cv::Scalar(0, 0, 200)), ".png");
  message.format = "bayer_rggb8; png compressed bgr8";
  message.data = colours;
  ASSERT_TRUE(RosImageDecoder().grey(message, grey));
  EXPECT_NEAR(grey(9, 5), 60, 1) << "of three values a pixel";
}

TEST(RosImage, CompressedDepth) {
  const float parameters[] = {20, 5};  // inverse depth's
  std::string data("\0\0\0\0", 4);
  data.append(reinterpret_cast<const char*>(parameters), sizeof parameters);
  data += encoded(cv::Mat(2, 2, CV_16UC1, cv::Scalar(1500)), ".png");
  RosCompressedImage message;
  message.format = "16UC1; compressedDepth png";
  message.data = data;
  ImageF depth;
  ASSERT_TRUE(RosImageDecoder().depth(message, 1000, depth));
  EXPECT_FLOAT_EQ(depth(1, 1), 1.5f);
  data.resize(12);
  data += encoded(cv::Mat(2, 2, CV_16UC1, cv::Scalar(15)), ".png");
  message.data = data;
  message.format = "32FC1; compressedDepth png";
  ASSERT_TRUE(RosImageDecoder().depth(message, 1000, depth));
  EXPECT_FLOAT_EQ(depth(1, 1), 2);
  message.format = "16UC1; compressedDepth rvl";
  EXPECT_THAT(RosImageDecoder().depth(message, 1000, depth).error().message, HasSubstr("rvl"));
  ImageU8 grey;
  EXPECT_THAT(RosImageDecoder().grey(message, grey).error().message, HasSubstr("that of a depth image"));
}

TEST(RosImage, SizesThatContradictEachOtherAreNamed) {
  std::string data;
  RosImage message = message_of("rgb8", {"abc", "def"}, 1, data);
  message.width = 2;
  EXPECT_THAT(error_of(message), AllOf(HasSubstr("step is 4"), HasSubstr("6 bytes")));
  message.width = 1;
  message.height = 3;
  EXPECT_THAT(error_of(message), HasSubstr("data has 8 bytes, the image takes 11"));
  message.height = 0;
  EXPECT_THAT(error_of(message), HasSubstr("1x0"));
  message.encoding = "bayer_rggb16";
  EXPECT_THAT(error_of(message), AllOf(HasSubstr("'bayer_rggb16'"), HasSubstr("bgra8")));
}

}  // namespace
}  // namespace covis::io
