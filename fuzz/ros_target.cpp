// SPDX-License-Identifier: Apache-2.0
// Messages of ROS with their images, the records of ROS 1 bags, and bags of ROS 2.
#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "covis/io/bag.h"
#include "covis/io/bag_ros1_check.h"
#include "covis/io/ros_camera.h"
#include "covis/io/ros_image.h"
#include "covis/io/ros_message.h"
#include "scratch.h"
#include "target.h"

namespace covis::fuzz {
namespace {

using io::RosWire;

// Values of a message in the order of its fields, in ROS 1's serialisation.
class Writer {
 public:
  template <class T>
  Writer& number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Writer& text(const std::string& value) {
    number(static_cast<uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  Writer& header() { return number(uint32_t{7}).number(uint32_t{100}).number(uint32_t{5}).text("camera"); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

template <class Message>
void decode(const Message& message) {
  constexpr double kScale = 1000;
  io::RosImageDecoder decoder;
  ImageU8 grey;
  ImageF depth;
  static_cast<void>(decoder.grey(message, grey));
  static_cast<void>(decoder.depth(message, kScale, depth));
  static_cast<void>(decoder.picture(message));
}

// The first byte chooses type and wire.
void run_message(std::string_view bytes) {
  if (bytes.empty()) return;
  const int kind = static_cast<uint8_t>(bytes[0]) % 6;
  const RosWire wire = kind < 3 ? RosWire::ros1 : RosWire::cdr;
  // A copy of its own, so that the sanitizer sees a read past its end.
  const std::vector<char> copy(bytes.begin() + 1, bytes.end());
  const std::string_view message(copy.data(), copy.size());
  static_cast<void>(io::parse_ros_stamp(message, wire));
  if (kind % 3 == 0) {
    if (const auto image = io::parse_ros_image(message, wire)) decode(*image);
  } else if (kind % 3 == 1) {
    if (const auto image = io::parse_ros_compressed_image(message, wire)) decode(*image);
  } else if (const auto info = io::parse_ros_camera_info(message, wire)) {
    static_cast<void>(io::raw_camera(*info));
    static_cast<void>(io::rectified_camera(*info));
    static_cast<void>(io::stereo_camera(*info, *info, io::StereoImages::raw));
  }
}

std::vector<std::string> message_seeds() {
  std::vector<std::string> seeds;
  const std::string pixels(4 * 3 * 4, '\x40');
  for (const auto& [encoding, size] :
       {std::pair<std::string, uint32_t>{"mono8", 1}, {"rgb8", 3}, {"16UC1", 2}, {"32FC1", 4}}) {
    Writer image;
    image.header().number(uint32_t{3}).number(uint32_t{4}).text(encoding).number(uint8_t{0}).number(4 * size);
    seeds.push_back('\0' + image.text(pixels.substr(0, 12 * size)).bytes());
  }
  Writer info;
  info.header().number(uint32_t{48}).number(uint32_t{64}).text("plumb_bob").number(uint32_t{5});
  for (int i = 0; i < 5; ++i) info.number(0.01);
  for (const double k : {50., 0., 32., 0., 50., 24., 0., 0., 1., 1., 0., 0., 0., 1., 0., 0., 0., 1.}) info.number(k);
  for (const double p : {50., 0., 32., -5., 0., 50., 24., 0., 0., 0., 1., 0.}) info.number(p);
  for (int i = 0; i < 2; ++i) info.number(uint32_t{0});
  for (int i = 0; i < 4; ++i) info.number(uint32_t{0});
  seeds.push_back('\2' + info.number(uint8_t{0}).bytes());
  return seeds;
}

void run_bag(std::string_view bytes) {
  const std::vector<char> copy(bytes.begin(), bytes.end());
  static_cast<void>(io::check_ros1_records({copy.data(), copy.size()}));
}

// The record of a bag: its header's fields, each NAME=VALUE, and its data.
std::string record(const std::vector<std::string>& fields, const std::string& data) {
  Writer header, all;
  for (const std::string& field : fields) header.text(field);
  return all.text(header.bytes()).text(data).bytes();
}

template <class T>
std::string field(const std::string& name, T value) {
  return name + "=" + std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

std::vector<std::string> bag_seeds() {
  const std::string version = "#ROSBAG V2.0\n";
  const auto connection = [] {
    return record({field("op", uint8_t{7}), field("conn", uint32_t{0}), "topic=/image"},
                  Writer().text("topic=/image").text("type=sensor_msgs/Image").bytes());
  };
  const auto begin = [&](uint64_t index) {
    return version + record({field("op", uint8_t{3}), field("index_pos", index), field("conn_count", uint32_t{1}),
                             field("chunk_count", uint32_t{1})},
                            std::string(64, ' '));
  };
  const std::string message =
      record({field("op", uint8_t{2}), field("conn", uint32_t{0}), field("time", uint64_t{1})}, "abcd");
  const std::string inner = connection() + message;
  const std::string chunk =
      record({field("op", uint8_t{5}), "compression=none", field("size", static_cast<uint32_t>(inner.size()))}, inner);
  const auto offset = static_cast<uint32_t>(connection().size());
  const std::string index = record(
      {field("op", uint8_t{4}), field("ver", uint32_t{1}), field("conn", uint32_t{0}), field("count", uint32_t{1})},
      Writer().number(uint64_t{1}).number(offset).bytes());
  const uint64_t chunk_at = begin(0).size(), index_at = chunk_at + chunk.size() + index.size();
  const std::string info =
      record({field("op", uint8_t{6}), field("ver", uint32_t{1}), field("chunk_pos", chunk_at),
              field("start_time", uint64_t{1}), field("end_time", uint64_t{1}), field("count", uint32_t{1})},
             Writer().number(uint32_t{0}).number(uint32_t{1}).bytes());
  return {version, begin(index_at) + chunk + index + connection() + info};
}

void run_ros2_bag(std::string_view bytes) {
  const MemoryFile file(bytes);
  const auto bag = io::open_ros2_bag({file.path()});
  if (!bag) return;
  constexpr size_t kMessages = 3;  // messages by topic
  std::string message;
  for (const io::BagTopic& topic : (*bag)->topics()) {
    for (size_t i = 0; i < std::min(kMessages, topic.messages.size()); ++i) {
      if ((*bag)->read(topic.messages[i], message)) require(message.size() <= bytes.size(), "a message is of its file");
    }
  }
}

// A database as recorders make it, with a message of each of two types.
std::vector<std::string> ros2_bag_seeds() {
  sqlite3* database = nullptr;
  sqlite3_open(":memory:", &database);
  sqlite3_exec(database,
               "PRAGMA page_size = 512;"
               "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
               "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
               "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
               "data BLOB NOT NULL);"
               "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
               "INSERT INTO topics VALUES(1, '/image', 'sensor_msgs/msg/Image', 'cdr', '');"
               "INSERT INTO topics VALUES(2, '/camera_info', 'sensor_msgs/msg/CameraInfo', 'cdr', '');"
               "INSERT INTO messages VALUES(1, 1, 1000000000, zeroblob(700));"
               "INSERT INTO messages VALUES(2, 2, 1000000000, x'00010000');",
               nullptr, nullptr, nullptr);
  sqlite3_int64 size = 0;
  unsigned char* bytes = sqlite3_serialize(database, "main", &size, 0);
  std::string seed(reinterpret_cast<const char*>(bytes), static_cast<size_t>(size));
  sqlite3_free(bytes);
  sqlite3_close(database);
  return {seed};
}

}  // namespace

std::vector<Target> ros_targets() {
  return {{"ros_message", run_message, message_seeds},
          {"bag_records", run_bag, bag_seeds},
          {"ros2_bag", run_ros2_bag, ros2_bag_seeds}};
}

}  // namespace covis::fuzz
