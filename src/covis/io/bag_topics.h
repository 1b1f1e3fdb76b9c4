// SPDX-License-Identifier: Apache-2.0
// The choice of a bag's topics: those named, or found by their names and types.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/sensor.h"
#include "covis/io/bag.h"
#include "covis/io/sequence.h"

namespace covis::io {

struct ChosenTopics {
  Sensor sensor = Sensor::monocular;
  const BagTopic* image = nullptr;  // or left image
  const BagTopic* right = nullptr;  // stereo only
  const BagTopic* depth = nullptr;  // RGB-D only
};

// Chooses topics that have messages. wanted: the sensor asked for, if any; without it, depth that is registered to a
// colour image comes before a stereo pair, that before other depth, and that before an image alone, but an image topic
// that is named alone stays alone. Errors list the image topics there are.
Result<ChosenTopics> choose_topics(const std::vector<BagTopic>& topics, const TopicNames& names,
                                   std::optional<Sensor> wanted);

// True for a topic of images that has messages.
bool has_images(const BagTopic& topic);
// Returns the topic of the camera's calibration, which lies beside the image's or, as recorders of RealSense's SDK have
// it, in X/info for X/image/data; nullptr: there is none.
const BagTopic* camera_info_of(const std::vector<BagTopic>& topics, const BagTopic& image);
// Returns the name that the topic would have: "/camera/color/camera_info".
std::string camera_info_name(const BagTopic& image);
// True when the topic's name is that of rectified images, such as image_rect_color.
bool is_rectified(const BagTopic& image);

}  // namespace covis::io
