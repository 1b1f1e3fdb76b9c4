// SPDX-License-Identifier: Apache-2.0
// For tests: messages of ROS, and small bags of ROS 1 and ROS 2 with them.
#pragma once

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "covis/io/ros_message.h"

namespace covis::io {

enum class Endian { little, big };

// Serialises fields in their order.
class WireWriter {
 public:
  explicit WireWriter(RosWire wire, Endian endian = Endian::little)
      : wire_(wire), swap_(wire == RosWire::cdr && endian == Endian::big) {
    if (wire == RosWire::cdr) bytes_ = {'\0', swap_ ? '\0' : '\1', '\0', '\0'};
  }

  template <class T>
  WireWriter& number(T value) {
    while (wire_ == RosWire::cdr && (bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back('\0');
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (swap_) std::reverse(raw, raw + sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  WireWriter& bytes(std::string_view value) {
    number(static_cast<uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  WireWriter& string(const std::string& value) {
    return bytes(wire_ == RosWire::cdr ? std::string_view(value.c_str(), value.size() + 1) : std::string_view(value));
  }
  WireWriter& header(Timestamp stamp, const std::string& frame) {
    if (wire_ == RosWire::ros1) number(uint32_t{7});
    number(static_cast<uint32_t>(stamp / 1'000'000'000)).number(static_cast<uint32_t>(stamp % 1'000'000'000));
    return string(frame);
  }
  const std::string& text() const { return bytes_; }

 private:
  RosWire wire_;
  bool swap_;
  std::string bytes_;
};

inline std::string serialised(const RosImage& m, RosWire wire, Endian endian = Endian::little) {
  return WireWriter(wire, endian)
      .header(m.header.stamp, std::string(m.header.frame))
      .number(m.height)
      .number(m.width)
      .string(std::string(m.encoding))
      .number(static_cast<uint8_t>(m.big_endian))
      .number(m.step)
      .bytes(m.data)
      .text();
}

inline std::string serialised(const RosCompressedImage& m, RosWire wire, Endian endian = Endian::little) {
  return WireWriter(wire, endian)
      .header(m.header.stamp, std::string(m.header.frame))
      .string(std::string(m.format))
      .bytes(m.data)
      .text();
}

inline std::string serialised(const RosCameraInfo& m, RosWire wire, Endian endian = Endian::little) {
  WireWriter writer(wire, endian);
  writer.header(m.header.stamp, std::string(m.header.frame)).number(m.height).number(m.width).string(m.model);
  writer.number(static_cast<uint32_t>(m.D.size()));
  for (const double value : m.D) writer.number(value);
  for (const double value : m.K) writer.number(value);
  for (const double value : m.R) writer.number(value);
  for (const double value : m.P) writer.number(value);
  writer.number(m.binning_x).number(m.binning_y).number(m.region_x).number(m.region_y);
  return writer.number(m.height).number(m.width).number(uint8_t{0}).text();
}

// The calibration of a camera of 64 x 48 pixels without distortion. bf: fx times baseline, of a right camera.
inline RosCameraInfo camera_info(double bf = 0) {
  RosCameraInfo info;
  info.width = 64;
  info.height = 48;
  info.model = "plumb_bob";
  info.D = {0, 0, 0, 0, 0};
  info.K = {50, 0, 32, 0, 51, 24, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {50, 0, 32, -bf, 0, 51, 24, 0, 0, 0, 1, 0};
  return info;
}

struct WrittenMessage {
  std::string topic, type;  // type: as ROS 1 says it
  Timestamp time = 0;
  std::string bytes;
};

// Writes a ROS 1 bag (wiki.ros.org/Bags/Format/2.0) of one chunk that is not compressed.
class Ros1BagWriter {
 public:
  static void write(const std::filesystem::path& file, const std::vector<WrittenMessage>& messages) {
    std::string chunk, connections, index, info;
    std::map<std::string, uint32_t> ids;
    std::map<uint32_t, std::string> entries;
    for (const WrittenMessage& m : messages) {
      if (!ids.contains(m.topic)) {
        const auto id = static_cast<uint32_t>(ids.size());
        ids[m.topic] = id;
        const std::string description = field("topic", m.topic) + field("type", m.type) +
                                        field("md5sum", std::string(32, '0')) + field("message_definition", "none");
        const std::string made = record({op(7), field("conn", raw(id)), field("topic", m.topic)}, description);
        connections += made;
        chunk += made;
      }
      const uint32_t id = ids[m.topic];
      entries[id] += time(m.time) + raw(static_cast<uint32_t>(chunk.size()));
      chunk += record({op(2), field("conn", raw(id)), field("time", time(m.time))}, m.bytes);
    }
    for (const auto& [id, entry] : entries) {
      const auto count = static_cast<uint32_t>(entry.size() / 12);
      index += record({op(4), field("ver", raw(1u)), field("conn", raw(id)), field("count", raw(count))}, entry);
      info += raw(id) + raw(count);
    }
    const std::string magic = "#ROSBAG V2.0\n";
    const uint64_t chunk_at = magic.size() + 4096;
    const std::string made =
        record({op(5), field("compression", "none"), field("size", raw(static_cast<uint32_t>(chunk.size())))}, chunk);
    const uint64_t index_at = messages.empty() ? chunk_at : chunk_at + made.size() + index.size();
    std::string head =
        record({op(3), field("index_pos", raw(index_at)), field("conn_count", raw(static_cast<uint32_t>(ids.size()))),
                field("chunk_count", raw(messages.empty() ? 0u : 1u))},
               "");
    const auto padding = static_cast<uint32_t>(4096 - head.size());
    head.replace(head.size() - 4, 4, raw(padding));
    head += std::string(padding, ' ');
    std::string all = magic + head;
    if (!messages.empty()) {
      all += made + index + connections;
      all += record({op(6), field("ver", raw(1u)), field("chunk_pos", raw(chunk_at)),
                     field("start_time", time(messages.front().time)), field("end_time", time(messages.back().time)),
                     field("count", raw(static_cast<uint32_t>(ids.size())))},
                    info);
    }
    std::ofstream(file, std::ios::binary) << all;
  }

 private:
  template <class T>
  static std::string raw(T value) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    return bytes;
  }
  static std::string time(Timestamp t) {
    return raw(static_cast<uint32_t>(t / 1'000'000'000)) + raw(static_cast<uint32_t>(t % 1'000'000'000));
  }
  static std::string field(const std::string& name, const std::string& value) {
    return raw(static_cast<uint32_t>(name.size() + 1 + value.size())) + name + "=" + value;
  }
  static std::string op(char code) { return field("op", std::string(1, code)); }
  static std::string record(const std::vector<std::string>& fields, const std::string& data) {
    std::string header;
    for (const std::string& f : fields) header += f;
    return raw(static_cast<uint32_t>(header.size())) + header + raw(static_cast<uint32_t>(data.size())) + data;
  }
};

// Writes a ROS 2 bag's .db3 file.
inline void write_ros2_bag(const std::filesystem::path& file, const std::vector<WrittenMessage>& messages) {
  std::filesystem::remove(file);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  const auto execute = [&](const std::string& sql) {
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  };
  execute(
      "PRAGMA synchronous=OFF;"
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT NULL); BEGIN");
  std::map<std::string, size_t> ids;
  for (const WrittenMessage& m : messages) {
    const auto [at, is_new] = ids.try_emplace(m.topic, ids.size() + 1);
    if (is_new) {
      std::string type = m.type;
      type.replace(type.find('/'), 1, "/msg/");
      execute("INSERT INTO topics VALUES(" + std::to_string(at->second) + ", '" + m.topic + "', '" + type +
              "', 'cdr', '')");
    }
    sqlite3_stmt* insert = nullptr;
    const std::string sql = "INSERT INTO messages(topic_id, timestamp, data) VALUES(" + std::to_string(at->second) +
                            ", " + std::to_string(m.time) + ", ?)";
    sqlite3_prepare_v2(database, sql.c_str(), -1, &insert, nullptr);
    sqlite3_bind_blob(insert, 1, m.bytes.data(), static_cast<int>(m.bytes.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(insert), SQLITE_DONE) << sqlite3_errmsg(database);
    sqlite3_finalize(insert);
  }
  execute("COMMIT");
  sqlite3_close(database);
}

// Collects messages and writes them as a bag of either kind.
class WrittenBag {
 public:
  explicit WrittenBag(RosWire wire) : wire_(wire) {}

  template <class Message>
  void add(const std::string& topic, const std::string& type, const Message& message, Timestamp time) {
    messages_.push_back({topic, type, time, serialised(message, wire_)});
  }
  void add(const std::string& topic, const RosCameraInfo& info) { add(topic, "sensor_msgs/CameraInfo", info, 1); }
  // Adds an image of rows without gaps.
  void add_image(const std::string& topic, Timestamp stamp, const std::string& encoding, std::string_view data,
                 std::array<uint32_t, 2> size = {64, 48}) {
    RosImage image;
    image.header = {stamp, "camera"};
    image.width = size[0];
    image.height = size[1];
    image.encoding = encoding;
    image.step = static_cast<uint32_t>(data.size() / size[1]);
    image.data = data;
    add(topic, "sensor_msgs/Image", image, stamp + 1'000'000);
  }
  void add_grey(const std::string& topic, Timestamp stamp, int grey) {
    add_image(topic, stamp, "mono8", std::string(64 * 48, static_cast<char>(grey)));
  }
  void add_depth(const std::string& topic, Timestamp stamp, uint16_t value) {
    const std::vector<uint16_t> values(64 * 48, value);
    add_image(topic, stamp, "16UC1", {reinterpret_cast<const char*>(values.data()), values.size() * 2});
  }
  void write(const std::filesystem::path& file) const {
    if (wire_ == RosWire::ros1) {
      Ros1BagWriter::write(file, messages_);
    } else {
      write_ros2_bag(file, messages_);
    }
  }
  std::vector<WrittenMessage>& messages() { return messages_; }

 private:
  RosWire wire_;
  std::vector<WrittenMessage> messages_;
};

}  // namespace covis::io
