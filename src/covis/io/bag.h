// SPDX-License-Identifier: Apache-2.0
// Bags of ROS: recorded messages by topic. ROS 1 bags are read by Debian's rosbag_storage, those of ROS 2 by SQLite.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/time.h"
#include "covis/io/ros_message.h"

namespace covis::io {

struct BagMessage {
  Timestamp time = 0;  // when it was recorded
  size_t file = 0;     // its number, from 0
  int64_t row = 0;     // its place in the file
};

// Messages are listed for the types that a recording needs: Image, CompressedImage and CameraInfo.
struct BagTopic {
  std::string name;                  // "/camera/color/image_raw"
  std::string type;                  // "sensor_msgs/Image", for both ROS 1 and 2
  std::vector<BagMessage> messages;  // by the time they were recorded
};

class Bag {
 public:
  virtual ~Bag() = default;
  virtual RosWire wire() const = 0;
  virtual const std::vector<BagTopic>& topics() const = 0;  // by name
  // Reads the first `most` bytes of a message, all if it has fewer. May be called in several threads.
  virtual Result<void> read(const BagMessage& message, std::string& bytes, size_t most = std::string::npos) = 0;
};

// True for a file whose name or beginning is that of a bag, and for a folder with .db3 files or the metadata.yaml of a
// bag.
bool is_bag(const std::filesystem::path& path);
// Lists the messages; reads none.
Result<std::unique_ptr<Bag>> open_bag(const std::filesystem::path& path);

// False when Covis was built without rosbag_storage.
bool reads_ros1_bags();

// The two formats, for open_bag(). files: all of one bag.
Result<std::unique_ptr<Bag>> open_ros1_bag(const std::filesystem::path& file);
Result<std::unique_ptr<Bag>> open_ros2_bag(const std::vector<std::filesystem::path>& files);

inline bool is_listed_type(const std::string& type) {
  return type == "sensor_msgs/Image" || type == "sensor_msgs/CompressedImage" || type == "sensor_msgs/CameraInfo";
}

// For the two sources of ROS 1 bags.
inline tl::unexpected<Error> damaged_ros1_bag(const std::filesystem::path& file, const std::string& problem) {
  return fail(file.string() + ": the bag can't be read: " + problem +
              ". If it was cut short, `rosbag reindex` makes what is there readable");
}

// plugin_ros1_bag.cpp
struct Ros1BagPlugin {
  static constexpr const char *kName = "covis_ros1_bag", *kPurpose = "reads bags of ROS 1";
  Result<std::unique_ptr<Bag>> (*open)(const std::filesystem::path& file);  // whose records were checked
};

}  // namespace covis::io
