// SPDX-License-Identifier: Apache-2.0
// The plug-in covis_ros1_bag: ROS 1 bags, by rosbag_storage. No other source includes headers of ROS.
#include <console_bridge/console.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <map>
#include <mutex>

#include "covis/io/bag.h"
#include "covis/io/plugin.h"

namespace covis::io {
namespace {

// Receives a message from rosbag_storage. More than the file can hold is refused: a damaged index may announce
// anything.
struct MessageBytes {
  std::string& bytes;
  const size_t most;

  uint8_t* advance(uint32_t size) {
    if (size > most) throw std::length_error("a message of " + std::to_string(size) + " bytes is announced");
    bytes.resize(size);
    return reinterpret_cast<uint8_t*>(bytes.data());
  }
};

class Ros1Bag : public Bag {
 public:
  explicit Ros1Bag(std::filesystem::path file) : file_(std::move(file)) {}

  Result<void> open() {
    console_bridge::noOutputHandler();  // its output would stand beside our message
    try {
      bag_.open(file_.string(), rosbag::bagmode::Read);
      list();
    } catch (const rosbag::BagUnindexedException&) {
      return damaged("it has no index");
    } catch (const std::exception& error) {  // those of rosbag_storage, and what damaged sizes lead to
      return damaged(error.what());
    }
    return {};
  }

  RosWire wire() const override { return RosWire::ros1; }
  const std::vector<BagTopic>& topics() const override { return topics_; }

  Result<void> read(const BagMessage& message, std::string& bytes, size_t most) override {
    const std::lock_guard lock(mutex_);
    try {
      MessageBytes stream{bytes, kLargestMessage};
      bytes.clear();
      messages_[static_cast<size_t>(message.row)].write(stream);
    } catch (const std::exception& error) {
      return damaged(error.what());
    }
    if (bytes.size() > most) bytes.resize(most);
    return {};
  }

 private:
  static constexpr size_t kLargestMessage = size_t{1} << 30;  // bytes

  tl::unexpected<Error> damaged(const std::string& problem) const { return damaged_ros1_bag(file_, problem); }

  void list() {
    rosbag::View all(bag_);
    std::map<std::string, BagTopic> topics;
    for (const rosbag::ConnectionInfo* connection : all.getConnections())
      topics[connection->topic] = {connection->topic, connection->datatype, {}};
    rosbag::View view(bag_, [](const rosbag::ConnectionInfo* c) { return is_listed_type(c->datatype); });
    for (const rosbag::MessageInstance& message : view) {
      topics[message.getTopic()].messages.push_back(
          {static_cast<Timestamp>(message.getTime().toNSec()), 0, static_cast<int64_t>(messages_.size())});
      messages_.push_back(message);
    }
    for (auto& [name, topic] : topics) topics_.push_back(std::move(topic));
  }

  const std::filesystem::path file_;
  std::vector<BagTopic> topics_;
  std::mutex mutex_;
  rosbag::Bag bag_;                                // guarded by mutex_
  std::vector<rosbag::MessageInstance> messages_;  // places in bag_
};

Result<std::unique_ptr<Bag>> open(const std::filesystem::path& file) {
  auto bag = std::make_unique<Ros1Bag>(file);
  if (auto opened = bag->open(); !opened) return tl::unexpected(opened.error());
  return bag;
}

}  // namespace
COVIS_PLUGIN(Ros1BagPlugin, open)

}  // namespace covis::io
