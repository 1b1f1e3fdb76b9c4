// SPDX-License-Identifier: Apache-2.0
// Messages of ROS as bags hold them: images, compressed images and camera calibrations (package sensor_msgs), out of
// ROS 1's serialisation or ROS 2's CDR. One parser serves both; sizes that a message announces are checked before use.
// Sources: wiki.ros.org/sensor_msgs; Object Management Group, "DDS Interoperability Wire Protocol", chapter 10 (CDR).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/time.h"

namespace covis::io {

// ROS 1: little-endian without padding, strings without a zero at their end. CDR: aligned, either endianness.
enum class RosWire { ros1, cdr };

inline constexpr size_t kRosStampBytes = 12;  // at a message's beginning, which hold its stamp

struct RosHeader {
  Timestamp stamp = 0;  // 0: the message has none
  std::string_view frame;
};

// All views are of the message's bytes, which must outlive them.
struct RosImage {
  RosHeader header;
  uint32_t width = 0, height = 0;  // pixels
  std::string_view encoding;       // "rgb8"
  bool big_endian = false;         // the order of bytes in pixels that have several
  uint32_t step = 0;               // bytes between rows
  std::string_view data;
};

struct RosCompressedImage {
  RosHeader header;
  std::string_view format;  // "png", or "16UC1; compressedDepth png" and the like
  std::string_view data;    // an image file; of compressedDepth behind a header of its own
};

// Row-major matrices as in sensor_msgs/CameraInfo.
struct RosCameraInfo {
  RosHeader header;
  uint32_t width = 0, height = 0;  // pixels
  std::string model;               // "plumb_bob"
  std::vector<double> D;           // distortion
  std::array<double, 9> K{}, R{};  // intrinsics of the raw image; rotation from the camera to the rectified one
  std::array<double, 12> P{};      // projection of the rectified image
  uint32_t binning_x = 0;          // 0 and 1: none
  uint32_t binning_y = 0;
  uint32_t region_x = 0, region_y = 0;  // the upper left corner of the image in that of the whole sensor
};

// Reads the stamp alone, for which kRosStampBytes are enough.
Result<Timestamp> parse_ros_stamp(std::string_view bytes, RosWire wire);
Result<RosHeader> parse_ros_header(std::string_view bytes, RosWire wire);
Result<RosImage> parse_ros_image(std::string_view bytes, RosWire wire);
Result<RosCompressedImage> parse_ros_compressed_image(std::string_view bytes, RosWire wire);
Result<RosCameraInfo> parse_ros_camera_info(std::string_view bytes, RosWire wire);

}  // namespace covis::io
