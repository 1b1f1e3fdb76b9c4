// SPDX-License-Identifier: Apache-2.0
#include "covis/io/ros_message.h"

#include <limits>

#include "covis/core/random.h"
#include "covis/io/ros_camera.h"
#include "covis/io/ros_image.h"
#include "covis/io/test_bags.h"

namespace covis::io {
namespace {

using testing::HasSubstr;

struct Form {
  RosWire wire;
  Endian endian;
};
constexpr Form kForms[] = {
    {RosWire::ros1, Endian::little}, {RosWire::cdr, Endian::little}, {RosWire::cdr, Endian::big}};

RosImage an_image() {
  RosImage image;
  image.header = {1'500'000'000'123'456'789, "camera_optical"};
  image.width = 4;
  image.height = 2;
  image.encoding = "mono8";
  image.step = 5;
  image.data = "abcd_efgh_";
  return image;
}

TEST(RosMessage, ImagesAreReadInEveryForm) {
  for (const Form& form : kForms) {
    const std::string bytes = serialised(an_image(), form.wire, form.endian);
    const auto read = parse_ros_image(bytes, form.wire);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->header.stamp, 1'500'000'000'123'456'789);
    EXPECT_EQ(read->header.frame, "camera_optical");
    EXPECT_EQ(read->width, 4u);
    EXPECT_EQ(read->height, 2u);
    EXPECT_EQ(read->encoding, "mono8");
    EXPECT_FALSE(read->big_endian);
    EXPECT_EQ(read->step, 5u);
    EXPECT_EQ(read->data, "abcd_efgh_");
    const auto stamp = parse_ros_stamp(std::string_view(bytes).substr(0, kRosStampBytes), form.wire);
    ASSERT_TRUE(stamp) << stamp.error().message;
    EXPECT_EQ(*stamp, read->header.stamp);
    EXPECT_EQ(parse_ros_header(bytes, form.wire)->frame, "camera_optical");
  }
}

TEST(RosMessage, CalibrationsAreReadInEveryForm) {
  RosCameraInfo info = camera_info(5);
  info.header.frame = "odd length";
  info.D = {0.1, -0.2, 0.3, 0.4};
  info.region_y = 7;
  for (const Form& form : kForms) {
    const std::string bytes = serialised(info, form.wire, form.endian);
    const auto read = parse_ros_camera_info(bytes, form.wire);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->width, 64u);
    EXPECT_EQ(read->model, "plumb_bob");
    EXPECT_EQ(read->D, info.D);
    EXPECT_EQ(read->K, info.K);
    EXPECT_EQ(read->R, info.R);
    EXPECT_EQ(read->P, info.P);
    EXPECT_EQ(read->region_y, 7u);
  }
}

TEST(RosMessage, WhatIsWrongIsNamed) {
  const std::string image = serialised(an_image(), RosWire::ros1);
  EXPECT_THAT(parse_ros_image(image.substr(0, image.size() - 1), RosWire::ros1).error().message,
              HasSubstr("sensor_msgs/Image: it is cut short at data: 10 bytes are needed, 9 are left"));
  std::string other = serialised(an_image(), RosWire::cdr);
  other[1] = 7;  // XCDR2
  EXPECT_THAT(parse_ros_image(other, RosWire::cdr).error().message, HasSubstr("it is not in CDR"));
  std::string late = image;
  late[11] = '\x7f';
  EXPECT_THAT(parse_ros_stamp(late, RosWire::ros1).error().message, HasSubstr("nanosec"));
  RosCameraInfo info = camera_info();
  info.K[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(parse_ros_camera_info(serialised(info, RosWire::cdr), RosWire::cdr).error().message,
              HasSubstr("K holds a number that is not finite"));
}

// Uses the bytes as each type of message, and what is read as an image and a camera.
void use(std::string_view bytes, RosWire wire) {
  RosImageDecoder decoder;
  ImageU8 grey;
  ImageF depth;
  if (const auto image = parse_ros_image(bytes, wire)) {
    (void)decoder.grey(*image, grey);
    (void)decoder.depth(*image, 1000, depth);
    (void)decoder.picture(*image);
  }
  if (const auto image = parse_ros_compressed_image(bytes, wire)) {
    (void)may_have_colours(*image);
    (void)decoder.grey(*image, grey);
    (void)decoder.depth(*image, 1000, depth);
  }
  if (const auto info = parse_ros_camera_info(bytes, wire)) {
    (void)raw_camera(*info);
    (void)rectified_camera(*info);
  }
  (void)parse_ros_stamp(bytes, wire);
}

// The sanitizers watch this one.
TEST(RosMessage, AnyBytesAreReadOrRefused) {
  Random random(hash_seed(1, 2, 3));
  for (const Form& form : kForms) {
    RosImage colours = an_image();
    colours.encoding = "bgr8";
    colours.width = 1;
    RosCompressedImage compressed;
    compressed.format = "16UC1; compressedDepth png";
    compressed.data = "0123456789ab";
    for (const std::string& whole :
         {serialised(an_image(), form.wire, form.endian), serialised(colours, form.wire, form.endian),
          serialised(compressed, form.wire, form.endian), serialised(camera_info(), form.wire, form.endian)}) {
      for (size_t size = 0; size <= whole.size(); ++size) {
        const std::vector<char> cut(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size));  // no byte behind
        use({cut.data(), cut.size()}, form.wire);
      }
      for (int round = 0; round < 2000; ++round) {
        std::string flipped = whole;
        for (int k = 0; k <= round % 3; ++k)
          flipped[random.below(static_cast<uint32_t>(flipped.size()))] = static_cast<char>(random.below(256));
        use(flipped, form.wire);
      }
    }
  }
}

}  // namespace
}  // namespace covis::io
