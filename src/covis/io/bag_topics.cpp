// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag_topics.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <tuple>
#include <utility>

namespace covis::io {
namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// True when a name has a part, which is given in lower case, in any case.
bool contains(const std::string& name, const char* part) { return lower_case(name).find(part) != std::string::npos; }

bool is_compressed(const BagTopic& topic) { return topic.type == "sensor_msgs/CompressedImage"; }

// The name without the transport: "/camera/image_raw" of "/camera/image_raw/compressed".
std::string image_name(const BagTopic& topic) {
  return is_compressed(topic) ? topic.name.substr(0, topic.name.rfind('/')) : topic.name;
}

// The name of the calibration beside the images of a name.
std::string name_beside(const std::string& image) {
  const size_t slash = image.rfind('/');
  return (slash == std::string::npos ? "" : image.substr(0, slash)) + "/camera_info";
}

// Colour that was registered to depth ("rgb_to_depth") is no depth.
bool is_depth(const BagTopic& topic) { return contains(topic.name, "depth") && !contains(topic.name, "_to_depth"); }

bool is_registered_to_colour(const BagTopic& topic) {
  return contains(topic.name, "depth_to_color") || contains(topic.name, "depth_to_rgb");
}

bool is_registered(const BagTopic& topic) {
  return is_registered_to_colour(topic) || contains(topic.name, "aligned_depth") || contains(topic.name, "registered");
}

bool is_colour(const BagTopic& topic) { return contains(topic.name, "color") || contains(topic.name, "rgb"); }

bool can_be_depth(const BagTopic& topic) {
  return is_depth(topic) && (!is_compressed(topic) || topic.name.ends_with("/compressedDepth"));
}

// Orders topics that could serve alike: the first is used.
auto image_rank(const BagTopic& topic) { return std::tuple(!is_colour(topic), is_compressed(topic), topic.name); }

auto depth_rank(const BagTopic& topic) {
  return std::tuple(!is_registered_to_colour(topic), !contains(topic.name, "aligned_depth"), !is_registered(topic),
                    is_compressed(topic), topic.name);
}

using Topics = std::vector<const BagTopic*>;

Topics image_topics(const std::vector<BagTopic>& topics) {
  Topics found;
  for (const BagTopic& topic : topics) {
    if (has_images(topic)) found.push_back(&topic);
  }
  return found;
}

std::string list_of(const Topics& topics) {
  std::string text;
  for (const BagTopic* topic : topics) {
    text += (text.empty() ? "" : ", ") + topic->name + " (" + topic->type + ", " +
            std::to_string(topic->messages.size()) + ")";
  }
  return text;
}

const BagTopic* named(const Topics& topics, const std::string& name) {
  for (const BagTopic* topic : topics) {
    if (topic->name == name || topic->name == "/" + name) return topic;
  }
  return nullptr;
}

// The topic of the right camera that belongs to one of the left; nullptr: there is none.
const BagTopic* right_of(const Topics& topics, const BagTopic& left) {
  using Names = std::pair<const char*, const char*>;
  for (const auto& [from, to] :
       {Names{"left", "right"}, Names{"infra1", "infra2"}, Names{"infrared_1", "infrared_2"}, Names{"cam0", "cam1"}}) {
    const std::string left_name = lower_case(left.name);
    std::string name = left_name;
    for (size_t at = name.find(from); at != std::string::npos; at = name.find(from, at + 1))
      name.replace(at, std::string(from).size(), to);
    if (name == left_name) continue;
    for (const BagTopic* right : topics) {
      if (lower_case(right->name) == name) return right;
    }
  }
  return nullptr;
}

const BagTopic* best_left(const Topics& topics) {
  const BagTopic* best = nullptr;
  const auto rank = [](const BagTopic& t) { return std::tuple(!is_rectified(t), is_compressed(t), t.name); };
  for (const BagTopic* topic : topics) {
    if (!is_depth(*topic) && right_of(topics, *topic) && (!best || rank(*topic) < rank(*best))) best = topic;
  }
  return best;
}

const BagTopic* best_depth(const Topics& topics) {
  const BagTopic* best = nullptr;
  for (const BagTopic* topic : topics) {
    if (can_be_depth(*topic) && (!best || depth_rank(*topic) < depth_rank(*best))) best = topic;
  }
  return best;
}

const BagTopic* best_image(const Topics& topics) {
  const BagTopic* best = nullptr;
  for (const BagTopic* topic : topics) {
    if (!is_depth(*topic) && (!best || image_rank(*topic) < image_rank(*best))) best = topic;
  }
  return best;
}

// The sensor that a bag serves when none is asked for.
Sensor richest(const Topics& images, const TopicNames& names) {
  if (!names.depth.empty()) return Sensor::rgbd;
  if (!names.right.empty()) return Sensor::stereo;
  if (!names.image.empty()) return Sensor::monocular;
  const BagTopic *image = best_image(images), *depth = best_depth(images);
  if (image && depth && is_colour(*image) && is_registered(*depth)) return Sensor::rgbd;
  if (best_left(images)) return Sensor::stereo;
  return image && depth ? Sensor::rgbd : Sensor::monocular;
}

}  // namespace

Result<ChosenTopics> choose_topics(const std::vector<BagTopic>& topics, const TopicNames& names,
                                   std::optional<Sensor> wanted) {
  const Topics images = image_topics(topics);
  if (images.empty()) {
    std::string others;
    for (const BagTopic& topic : topics) others += (others.empty() ? "" : ", ") + topic.name + " (" + topic.type + ")";
    return fail("there is no image in the bag; its topics are " + (others.empty() ? "none" : others));
  }
  const std::string there_are = "; the image topics are " + list_of(images);
  for (const std::string& name : {names.image, names.right, names.depth}) {
    if (!name.empty() && !named(images, name)) return fail("topic " + name + ": there is no image of it" + there_are);
  }
  ChosenTopics chosen;
  chosen.sensor = wanted.value_or(richest(images, names));
  if (!names.right.empty() && chosen.sensor != Sensor::stereo)
    return fail("topic " + names.right + ": a right image is for --sensor stereo");
  if (!names.depth.empty() && chosen.sensor != Sensor::rgbd)
    return fail("topic " + names.depth + ": depth is for --sensor rgbd");

  if (!names.image.empty()) {
    chosen.image = named(images, names.image);
  } else if (chosen.sensor == Sensor::stereo) {
    chosen.image = best_left(images);
  } else {
    chosen.image = best_image(images);
  }
  if (chosen.sensor == Sensor::stereo) {
    if (!chosen.image)
      return fail("no stereo pair is found by the topics' names; name --topic and --right-topic" + there_are);
    chosen.right = names.right.empty() ? right_of(images, *chosen.image) : named(images, names.right);
    if (!chosen.right)
      return fail("topic " + chosen.image->name + ": its right one is not found by name; name --right-topic" +
                  there_are);
  }
  if (!chosen.image) return fail("no topic but that of depth has images; name --topic" + there_are);
  if (chosen.sensor == Sensor::rgbd) {
    chosen.depth = names.depth.empty() ? best_depth(images) : named(images, names.depth);
    if (!chosen.depth) return fail("no depth is found by the topics' names; name --depth-topic" + there_are);
  }
  if (chosen.image == chosen.right || chosen.image == chosen.depth)
    return fail("topic " + chosen.image->name + ": it can't be both images of a frame" + there_are);
  return chosen;
}

bool has_images(const BagTopic& topic) {
  return (topic.type == "sensor_msgs/Image" || is_compressed(topic)) && !topic.messages.empty();
}

std::string camera_info_name(const BagTopic& image) {
  const std::string name = image_name(image);
  constexpr std::string_view kRealSense = "/image/data";
  if (name.ends_with(kRealSense)) return name.substr(0, name.size() - kRealSense.size()) + "/info/camera_info";
  return name_beside(name);
}

const BagTopic* camera_info_of(const std::vector<BagTopic>& topics, const BagTopic& image) {
  for (const std::string& name : {camera_info_name(image), name_beside(image_name(image))}) {
    for (const BagTopic& topic : topics) {
      if (topic.name == name && topic.type == "sensor_msgs/CameraInfo" && !topic.messages.empty()) return &topic;
    }
  }
  return nullptr;
}

bool is_rectified(const BagTopic& image) {
  const std::string name = image_name(image);
  return contains(name.substr(name.rfind('/') + 1), "rect");
}

}  // namespace covis::io
