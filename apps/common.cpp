// SPDX-License-Identifier: Apache-2.0
#include "common.h"

#include <CLI/CLI.hpp>
#include <csignal>

#include "apps/run/run_json.h"
#include "covis/core/log.h"

namespace covis::app {
namespace {

void on_signal(int signal) {
  interrupted = signal;
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::map<std::string, Sensor> kSensors{
    {"mono", Sensor::monocular}, {"stereo", Sensor::stereo}, {"rgbd", Sensor::rgbd}};

const std::map<std::string, io::SequenceKind> kKinds{{"tum", io::SequenceKind::tum},
                                                     {"kitti", io::SequenceKind::kitti},
                                                     {"euroc", io::SequenceKind::euroc},
                                                     {"tartanair", io::SequenceKind::tartanair},
                                                     {"openloris", io::SequenceKind::openloris},
                                                     {"open3d", io::SequenceKind::open3d},
                                                     {"bag", io::SequenceKind::bag},
                                                     {"images", io::SequenceKind::images},
                                                     {"video", io::SequenceKind::video},
                                                     {"camera", io::SequenceKind::camera}};

std::atomic<int> interrupted = 0;

io::SequenceOptions Reading::options() const {
  io::SequenceOptions options;
  if (!sensor.empty()) options.sensor = kSensors.at(sensor);
  if (!kind.empty()) options.kind = kKinds.at(kind);
  options.camera_file = camera;
  options.topics = topics;
  options.first = first;
  options.count = count;
  options.stride = stride;
  return options;
}

void add_reading_options(CLI::App& command, Reading& reading) {
  command.add_option("--sensor", reading.sensor, "mono, stereo or rgbd (default: the richest the recording allows)")
      ->check(CLI::IsMember(keys(kSensors)));
  command.add_option("--kind", reading.kind, "kind of recording (default: recognised)")
      ->check(CLI::IsMember(keys(kKinds)));
  command.add_option("--camera", reading.camera, "camera YAML, for what the recording does not say (docs/input.md)");
  command.add_option("--topic", reading.topics.image, "image topic of a bag, the left one of a stereo pair");
  command.add_option("--right-topic", reading.topics.right, "right image topic of a bag");
  command.add_option("--depth-topic", reading.topics.depth, "depth topic of a bag, registered to the image");
  command.add_option("--first", reading.first, "index of the first frame")->check(CLI::NonNegativeNumber);
  command.add_option("--count", reading.count, "frames at most");
  command.add_option("--stride", reading.stride, "every n-th frame")->check(CLI::PositiveNumber);
}

nlohmann::json camera_json(const Camera& camera) {
  static constexpr const char* kModels[] = {"pinhole", "brown_conrady", "kannala_brandt"};
  nlohmann::json json = pinhole_json(camera.pinhole);
  json["width"] = camera.width;
  json["height"] = camera.height;
  json["model"] = kModels[static_cast<int>(camera.distortion)];
  if (camera.pinhole.bf > 0) json["baseline"] = camera.pinhole.baseline();
  if (camera.distortion != Distortion::none) json["distortion"] = camera.coefficients;
  return json;
}

Result<void> set_all(const std::vector<std::string>& settings, const Fields& known) {
  for (const std::string& setting : settings) {
    const size_t equals = setting.find('=');
    if (equals == std::string::npos) return fail("--set " + setting + ": it must be NAME=VALUE");
    if (auto set = set_field(known, setting.substr(0, equals), setting.substr(equals + 1)); !set) return set;
  }
  return {};
}

int fail_with(const std::string& message) {
  log(LogLevel::error, message);
  return 1;
}

int fail_with(const Error& error) { return fail_with(error.message); }

void end_well_on_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

}  // namespace covis::app
