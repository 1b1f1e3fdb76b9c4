// SPDX-License-Identifier: Apache-2.0
// Bags of ROS 1 and ROS 2. Their images are named as if a bag was a folder: BAG/TOPIC/NUMBER.
#include <algorithm>
#include <charconv>
#include <map>

#include "covis/io/bad_frames.h"
#include "covis/io/bag.h"
#include "covis/io/bag_topics.h"
#include "covis/io/recording.h"
#include "covis/io/ros_camera.h"
#include "covis/io/ros_image.h"
#include "covis/io/stamp_pairs.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

// A bag that is open, and the topics whose images may be read, by the folder that their images' names give them.
struct OpenBag {
  fs::path path;
  std::unique_ptr<Bag> bag;
  std::map<std::string, const BagTopic*> image_topics;

  std::string folder_of(const BagTopic& topic) const {
    return path.string() + (topic.name.starts_with('/') ? "" : "/") + topic.name;
  }
};

Error named(const fs::path& name, const Error& error) { return {name.string() + ": " + error.message}; }

class BagImages : public ImageSource {
 public:
  explicit BagImages(std::shared_ptr<const OpenBag> bag) : bag_(std::move(bag)) {}

  void expect(const ExpectedSize& size) override { decoder_.expect(size); }
  void use_bits(int bits) override { decoder_.use_bits(bits); }
  Result<void> grey(const fs::path& name, ImageU8& image) override {
    return with_message<Result<void>>(name, [&](const auto& message) { return decoder_.grey(message, image); });
  }
  Result<void> depth(const fs::path& name, double scale, ImageF& depth) override {
    return with_message<Result<void>>(name, [&](const auto& message) { return decoder_.depth(message, scale, depth); });
  }
  Result<Picture> picture(const fs::path& name) override {
    return with_message<Result<Picture>>(name, [&](const auto& message) { return decoder_.picture(message); });
  }
  bool may_have_colours(const fs::path& name) override {
    const auto may = with_message<Result<bool>>(
        name, [](const auto& message) { return Result<bool>(io::may_have_colours(message)); });
    return may && *may;
  }

 private:
  // Reads and parses the message that the name is of, and returns what use(message) does of it.
  template <class Returned, class Use>
  Returned with_message(const fs::path& name, Use&& use) {
    const auto topic = bag_->image_topics.find(name.parent_path().string());
    const std::string number = name.filename().string();
    size_t at = 0;
    std::from_chars(number.data(), number.data() + number.size(), at);
    if (topic == bag_->image_topics.end() || at >= topic->second->messages.size())
      return fail(name.string() + ": there is no such message");
    if (auto read = bag_->bag->read(topic->second->messages[at], bytes_); !read) return tl::unexpected(read.error());
    Returned used = topic->second->type == "sensor_msgs/Image"
                        ? parsed<Returned>(parse_ros_image(bytes_, bag_->bag->wire()), use)
                        : parsed<Returned>(parse_ros_compressed_image(bytes_, bag_->bag->wire()), use);
    if (!used) return tl::unexpected(named(name, used.error()));
    return used;
  }

  template <class Returned, class Message, class Use>
  static Returned parsed(const Result<Message>& message, Use&& use) {
    if (!message) return tl::unexpected(message.error());
    return use(*message);
  }

  const std::shared_ptr<const OpenBag> bag_;
  RosImageDecoder decoder_;
  std::string bytes_;  // the message
};

// An image of a topic, before it is known whether it belongs to a frame.
struct StampedMessage {
  Timestamp stamp;  // the header's; 0 or less: it has none
  Timestamp time;   // the bag's
  fs::path name;
};

// Lists the messages of a topic that can be read.
Result<std::vector<StampedMessage>> list_messages(const OpenBag& bag, const BagTopic& topic, Recording& recording) {
  std::vector<StampedMessage> found;
  std::string bytes, problem;
  for (size_t i = 0; i < topic.messages.size(); ++i) {
    const fs::path name = fs::path(bag.folder_of(topic)) / std::to_string(i);
    if (auto read = bag.bag->read(topic.messages[i], bytes, kRosStampBytes); !read) return tl::unexpected(read.error());
    const auto stamp = parse_ros_stamp(bytes, bag.bag->wire());
    if (stamp) {
      found.push_back({*stamp, topic.messages[i].time, name});
    } else if (problem.empty()) {
      problem = name.string() + ": " + stamp.error().message;
    }
  }
  if (found.empty()) return fail(problem);
  const size_t all = topic.messages.size();
  if (found.size() < all)
    note_left_out(all - found.size(), all, "messages of " + topic.name + " can't be read (" + problem + ")", recording);
  return found;
}

bool are_stamped(const std::vector<StampedMessage>& messages) {
  const auto stamped = std::count_if(messages.begin(), messages.end(), [](const auto& m) { return m.stamp > 0; });
  return 2 * static_cast<size_t>(stamped) >= messages.size();
}

// Leaves out messages that have no stamp, where others have one, and those whose stamps do not rise.
Result<void> leave_out_unstamped(const BagTopic& topic, BadFrames bad_frames, std::vector<StampedMessage>& messages,
                                 Recording& recording) {
  const size_t all = messages.size();
  std::erase_if(messages, [](const StampedMessage& m) { return m.stamp <= 0; });
  if (const size_t bad = all - messages.size(); bad > 0)
    note_left_out(bad, all, "messages of " + topic.name + " have no stamp, as the others have,", recording);
  std::vector<Timestamp> stamps;
  for (const StampedMessage& message : messages) stamps.push_back(message.stamp);
  const auto rising = pass_over_fallen(
      stamps, "messages of " + topic.name, [&](size_t i) { return messages[i].name.string(); }, bad_frames, recording);
  if (!rising) return tl::unexpected(rising.error());
  std::vector<StampedMessage> kept;
  for (const size_t i : *rising) kept.push_back(std::move(messages[i]));
  messages = std::move(kept);
  return {};
}

// The usable messages of both topics by one clock: that of the headers where both have it, else the bag's.
Result<std::vector<std::vector<StampedMessage>>> stamped_messages(const OpenBag& bag,
                                                                  const std::vector<const BagTopic*>& topics,
                                                                  BadFrames bad_frames, Recording& recording) {
  std::vector<std::vector<StampedMessage>> found;
  for (const BagTopic* topic : topics) {
    auto messages = list_messages(bag, *topic, recording);
    if (!messages) return tl::unexpected(messages.error());
    found.push_back(std::move(*messages));
  }
  if (!std::all_of(found.begin(), found.end(), are_stamped)) {
    for (auto& messages : found) {
      for (StampedMessage& message : messages) message.stamp = message.time;
    }
  }
  for (size_t k = 0; k < topics.size(); ++k) {
    if (auto left = leave_out_unstamped(*topics[k], bad_frames, found[k], recording); !left)
      return tl::unexpected(left.error());
  }
  return found;
}

// Lists the frames: the images, paired with those of the right camera or of depth if there are any.
Result<void> list_bag_frames(const OpenBag& bag, const ChosenTopics& topics, BadFrames bad_frames,
                             Recording& recording) {
  const BagTopic* other = topics.right ? topics.right : topics.depth;
  std::vector<const BagTopic*> both{topics.image};
  if (other) both.push_back(other);
  const auto messages = stamped_messages(bag, both, bad_frames, recording);
  if (!messages) return tl::unexpected(messages.error());
  const std::vector<StampedMessage>& images = messages->front();
  std::vector<FrameFiles>& frames = recording.frames;
  if (!other) {
    for (const StampedMessage& image : images) frames.push_back({image.stamp, image.name, {}, {}});
    return {};
  }
  const std::vector<StampedMessage>& others = messages->back();
  const auto stamps = [](const std::vector<StampedMessage>& of) {
    std::vector<Timestamp> found;
    for (const StampedMessage& message : of) found.push_back(message.stamp);
    return found;
  };
  for (const auto& [i, o] : pair_by_stamps(stamps(images), stamps(others))) {
    FrameFiles frame{images[i].stamp, images[i].name, {}, {}};
    (topics.right ? frame.right : frame.depth) = others[o].name;
    frames.push_back(std::move(frame));
  }
  if (frames.empty()) {
    return fail(bag.path.string() + ": no image of " + topics.image->name + " has one of " + other->name +
                " within 20 ms");
  }
  if (frames.size() < images.size()) {
    note_left_out(images.size() - frames.size(), images.size(),
                  "images of " + topics.image->name + " have none of " + other->name + " within 20 ms", recording);
  }
  return {};
}

Result<RosCameraInfo> read_camera_info(const OpenBag& bag, const BagTopic& image) {
  const BagTopic* topic = camera_info_of(bag.bag->topics(), image);
  if (!topic) return tl::unexpected(no_calibration(bag.path, camera_info_name(image)));
  std::string bytes;
  if (auto read = bag.bag->read(topic->messages.front(), bytes); !read) return tl::unexpected(read.error());
  auto info = parse_ros_camera_info(bytes, bag.bag->wire());
  if (!info) return tl::unexpected(named(bag.folder_of(*topic), info.error()));
  return info;
}

// Sets camera, calibration, depth scale and rectification. A given camera file means that stereo images are rectified
// already.
Result<void> find_bag_camera(const Request& request, const OpenBag& bag, const ChosenTopics& topics,
                             Recording& recording) {
  constexpr double kMillimetres = 1000;
  if (request.given) {
    take_camera(*request.given, kMillimetres, recording);
    return {};
  }
  recording.depth_scale = kMillimetres;
  const auto info = read_camera_info(bag, *topics.image);
  if (!info) return tl::unexpected(info.error());
  recording.calibration = bag.path.string() + camera_info_of(bag.bag->topics(), *topics.image)->name;
  if (!topics.right) {
    const auto camera = is_rectified(*topics.image) && info->P[0] > 0 ? rectified_camera(*info) : raw_camera(*info);
    if (!camera) return tl::unexpected(named(recording.calibration, camera.error()));
    recording.camera = *camera;
    return {};
  }
  const auto right = read_camera_info(bag, *topics.right);
  if (!right) return tl::unexpected(right.error());
  auto stereo = stereo_camera(*info, *right, is_rectified(*topics.image) ? StereoImages::rectified : StereoImages::raw);
  if (!stereo) return tl::unexpected(named(recording.calibration, stereo.error()));
  recording.camera = stereo->camera;
  recording.rectification = std::move(stereo->rectification);
  return {};
}

// Notes when the first depth image and the first image say that they are of different cameras.
void note_other_frame(const OpenBag& bag, const ChosenTopics& topics, std::vector<std::string>& notes) {
  std::string frames[2];
  size_t count = 0;
  for (const BagTopic* topic : {topics.image, topics.depth}) {
    std::string bytes;
    if (!bag.bag->read(topic->messages.front(), bytes)) return;
    const auto header = parse_ros_header(bytes, bag.bag->wire());
    if (header) frames[count++] = header->frame;
  }
  if (count == 2 && frames[0] != frames[1]) {
    notes.push_back("images of " + topics.image->name + " are of frame_id " + frames[0] + ", those of " +
                    topics.depth->name + " of " + frames[1] + ": depth must be registered to the image");
  }
}

// Notes the image topics that were not chosen.
void note_unused(const OpenBag& bag, const ChosenTopics& topics, std::vector<std::string>& notes) {
  std::string unused;
  for (const BagTopic& topic : bag.bag->topics()) {
    const bool used = &topic == topics.image || &topic == topics.right || &topic == topics.depth;
    if (!used && has_images(topic)) unused += (unused.empty() ? "" : ", ") + topic.name;
  }
  if (!unused.empty()) notes.push_back("image topics that are not used: " + unused);
}

// Fails when none of a few frames can be decoded: then their encoding is one that nobody reads.
Result<void> check_images(const std::shared_ptr<const OpenBag>& bag, const Recording& recording) {
  BagImages images(bag);
  ImageU8 image;
  ImageF depth;
  Result<void> first;
  const size_t count = recording.frames.size();
  for (const size_t k : {size_t{0}, count / 2, count - 1}) {
    const FrameFiles& frame = recording.frames[k];
    Result<void> read = images.grey(frame.image, image);
    if (read && !frame.right.empty()) read = images.grey(frame.right, image);
    if (read && !frame.depth.empty()) read = images.depth(frame.depth, recording.depth_scale, depth);
    if (read) return {};  // next() will report the others
    if (first) first = read;
  }
  return first;
}

std::string topics_text(const ChosenTopics& topics) {
  std::string text = topics.image->name;
  if (topics.right) text += ", " + topics.right->name;
  if (topics.depth) text += ", " + topics.depth->name;
  return text;
}

}  // namespace

Result<Recording> read_bag(const Request& request) {
  auto opened = open_bag(request.folder);
  if (!opened) return tl::unexpected(opened.error());
  auto bag = std::make_shared<OpenBag>();
  bag->path = request.folder;
  bag->bag = std::move(*opened);
  const auto topics = choose_topics(bag->bag->topics(), request.topics, request.wanted);
  if (!topics) return tl::unexpected(named(request.folder, topics.error()));
  for (const BagTopic* topic : {topics->image, topics->right, topics->depth}) {
    if (topic) bag->image_topics[bag->folder_of(*topic)] = topic;
  }
  Recording recording;
  recording.kind = SequenceKind::bag;
  recording.sensor = topics->sensor;
  recording.name = (bag->bag->wire() == RosWire::ros1 ? "ROS 1 bag, " : "ROS 2 bag, ") + topics_text(*topics);
  if (auto found = find_bag_camera(request, *bag, *topics, recording); !found) return tl::unexpected(found.error());
  if (auto listed = list_bag_frames(*bag, *topics, request.bad_frames, recording); !listed)
    return tl::unexpected(listed.error());
  if (topics->depth) note_other_frame(*bag, *topics, recording.notes);
  if (!request.topics.any()) note_unused(*bag, *topics, recording.notes);
  if (auto checked = check_images(bag, recording); !checked) return tl::unexpected(checked.error());
  recording.images = [bag = std::shared_ptr<const OpenBag>(bag)] { return std::make_unique<BagImages>(bag); };
  return recording;
}

}  // namespace covis::io
