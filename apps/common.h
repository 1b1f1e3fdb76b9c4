// SPDX-License-Identifier: Apache-2.0
// Shared by the commands: names of settings, frame selection, errors, Ctrl-C.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/fields.h"
#include "covis/geometry/camera.h"
#include "covis/io/sequence.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace covis::app {

inline constexpr const char* kRecordingPath =  // help for PATH
    "folder (TUM RGB-D, KITTI, EuRoC, TartanAir, OpenLORIS-Scene, ICL-NUIM, images with or without depth), ROS bag, "
    "video file, or camera number";
extern const std::map<std::string, Sensor> kSensors;
extern const std::map<std::string, io::SequenceKind> kKinds;

template <class Value>
std::vector<std::string> keys(const std::map<std::string, Value>& map) {
  std::vector<std::string> names;
  names.reserve(map.size());
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

template <class Value>
std::string name_of(const std::map<std::string, Value>& map, Value wanted) {
  for (const auto& [name, value] : map) {
    if (value == wanted) return name;
  }
  return {};
}

// Selection of the frames of a recording, and how they are read.
struct Reading {
  std::string sensor, kind, camera;
  io::TopicNames topics;
  int64_t first = 0, count = -1;
  int stride = 1;
  bool skip_bad = false;

  io::SequenceOptions options() const;
};
// Adds --sensor, --kind, --camera, the topics of bags, --first, --count, --stride and --skip-bad.
void add_reading_options(CLI::App& command, Reading& reading);

// Checks of options; CLI11's own name no bounds that a person would, and let "nan" pass. A whole number is for
// Option::transform(): its leading zeros go.
CLI::Validator whole_number_from(int64_t least, int64_t most = std::numeric_limits<int64_t>::max());
CLI::Validator positive_number();

// Sets the fields that --set names, each as NAME=VALUE.
Result<void> set_all(const std::vector<std::string>& settings, const Fields& known);
// Takes what --features says, unless `settings` say another number of keypoints; 0: it was not given.
Result<void> set_features(int given, const std::vector<std::string>& settings, int& features);

nlohmann::json camera_json(const Camera& camera);
// Prints it on stdout. A path in it need not be UTF-8.
void print_json(const nlohmann::json& json);

// Prints the error and returns the exit code for it.
int fail_with(const std::string& message);
int fail_with(const Error& error);

// The number of the signal (Ctrl-C or SIGTERM) that requested a regular end; 0: none. It is atomic because the handler
// may run on any thread, so a sig_atomic_t would not suffice.
extern std::atomic<int> interrupted;
static_assert(std::atomic<int>::is_always_lock_free);
// Makes the first signal set `interrupted`, and the second end the process.
void end_well_on_signals();

}  // namespace covis::app
