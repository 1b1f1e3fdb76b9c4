// SPDX-License-Identifier: Apache-2.0
#include "covis/io/ros_message.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

namespace covis::io {
namespace {

static_assert(std::endian::native == std::endian::little);

// Reads fields in their order. The first that does not fit, or holds nonsense, becomes the message's error; those after
// it read as zero.
class WireReader {
 public:
  WireReader(const char* type, std::string_view bytes, RosWire wire) : type_(type), rest_(bytes), wire_(wire) {
    if (wire != RosWire::cdr) return;
    // Encapsulation: 0, then 0 for big-endian or 1 for little-endian, then two bytes of options.
    const std::string_view head = take("its first bytes", 4);
    if (problem_) return;
    if (head[0] != 0 || (head[1] != 0 && head[1] != 1)) {
      stop("it is not in CDR: its encapsulation is " + std::to_string(static_cast<unsigned char>(head[0])) + " " +
           std::to_string(static_cast<unsigned char>(head[1])) + ", it must be 0 0 or 0 1");
    }
    swap_ = !problem_ && head[1] == 0;
    at_ = 0;  // alignment counts from behind the encapsulation
  }

  template <class T>
  T number(const char* field) {
    if (wire_ == RosWire::cdr) take(field, (sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    const std::string_view bytes = take(field, sizeof(T));
    T value{};
    if (problem_) return value;
    char swapped[sizeof(T)];
    std::copy(bytes.begin(), bytes.end(), swapped);
    if (swap_) std::reverse(swapped, swapped + sizeof(T));
    std::memcpy(&value, swapped, sizeof(T));
    return value;
  }

  // A string, or a sequence of bytes.
  std::string_view bytes(const char* field) {
    const auto size = number<uint32_t>(field);
    return take(field, size);
  }
  std::string_view string(const char* field) {
    std::string_view text = bytes(field);
    if (wire_ == RosWire::cdr && text.ends_with('\0')) text.remove_suffix(1);
    return text;
  }

  template <size_t kSize>
  std::array<double, kSize> numbers(const char* field) {
    std::array<double, kSize> values;
    for (double& value : values) value = finite(field);
    return values;
  }
  std::vector<double> numbers_of_any_count(const char* field) {
    const auto size = number<uint32_t>(field);
    std::vector<double> values;
    for (uint32_t i = 0; i < size && !problem_; ++i) values.push_back(finite(field));
    return values;
  }

  RosHeader header() {
    if (wire_ == RosWire::ros1) number<uint32_t>("header.seq");
    RosHeader header;
    header.stamp = stamp();
    header.frame = string("header.frame_id");
    return header;
  }
  Timestamp stamp() {
    // Unsigned in ROS 1, signed in ROS 2; negative ones are of nobody's clock.
    const auto seconds = number<uint32_t>("header.stamp.sec");
    const auto nanoseconds = number<uint32_t>("header.stamp.nanosec");
    if (nanoseconds >= 1'000'000'000)
      stop("header.stamp.nanosec is " + std::to_string(nanoseconds) + ", it must be less than 1000000000");
    return problem_ ? 0 : static_cast<Timestamp>(seconds) * 1'000'000'000 + nanoseconds;
  }

  template <class Message>
  Result<Message> result(Message message) {
    if (problem_) return fail(std::string(type_) + ": " + *problem_);
    return message;
  }

 private:
  double finite(const char* field) {
    const auto value = number<double>(field);
    if (!std::isfinite(value)) stop(std::string(field) + " holds a number that is not finite");
    return problem_ ? 0 : value;
  }

  std::string_view take(const char* field, size_t size) {
    if (size > rest_.size()) {
      stop("it is cut short at " + std::string(field) + ": " + std::to_string(size) + " bytes are needed, " +
           std::to_string(rest_.size()) + " are left");
    }
    if (problem_) return {};
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    at_ += size;
    return taken;
  }

  void stop(const std::string& problem) {
    if (!problem_) problem_ = problem;
  }

  const char* type_;
  std::string_view rest_;
  const RosWire wire_;
  bool swap_ = false;
  size_t at_ = 0;  // bytes taken
  std::optional<std::string> problem_;
};

}  // namespace

Result<Timestamp> parse_ros_stamp(std::string_view bytes, RosWire wire) {
  WireReader reader("message", bytes, wire);
  if (wire == RosWire::ros1) reader.number<uint32_t>("header.seq");
  const Timestamp stamp = reader.stamp();
  return reader.result(stamp);
}

Result<RosHeader> parse_ros_header(std::string_view bytes, RosWire wire) {
  WireReader reader("message", bytes, wire);
  const RosHeader header = reader.header();
  return reader.result(header);
}

Result<RosImage> parse_ros_image(std::string_view bytes, RosWire wire) {
  WireReader reader("sensor_msgs/Image", bytes, wire);
  RosImage image;
  image.header = reader.header();
  image.height = reader.number<uint32_t>("height");
  image.width = reader.number<uint32_t>("width");
  image.encoding = reader.string("encoding");
  image.big_endian = reader.number<uint8_t>("is_bigendian") != 0;
  image.step = reader.number<uint32_t>("step");
  image.data = reader.bytes("data");
  return reader.result(image);
}

Result<RosCompressedImage> parse_ros_compressed_image(std::string_view bytes, RosWire wire) {
  WireReader reader("sensor_msgs/CompressedImage", bytes, wire);
  RosCompressedImage image;
  image.header = reader.header();
  image.format = reader.string("format");
  image.data = reader.bytes("data");
  return reader.result(image);
}

Result<RosCameraInfo> parse_ros_camera_info(std::string_view bytes, RosWire wire) {
  WireReader reader("sensor_msgs/CameraInfo", bytes, wire);
  RosCameraInfo info;
  info.header = reader.header();
  info.height = reader.number<uint32_t>("height");
  info.width = reader.number<uint32_t>("width");
  info.model = reader.string("distortion_model");
  info.D = reader.numbers_of_any_count("D");
  info.K = reader.numbers<9>("K");
  info.R = reader.numbers<9>("R");
  info.P = reader.numbers<12>("P");
  info.binning_x = reader.number<uint32_t>("binning_x");
  info.binning_y = reader.number<uint32_t>("binning_y");
  info.region_x = reader.number<uint32_t>("roi.x_offset");
  info.region_y = reader.number<uint32_t>("roi.y_offset");
  return reader.result(info);
}

}  // namespace covis::io
