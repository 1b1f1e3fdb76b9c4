// SPDX-License-Identifier: Apache-2.0
#include "common.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <set>

#include "apps/run/run_json.h"
#include "covis/core/log.h"
#include "covis/io/files.h"

namespace covis::app {
namespace {

constexpr int kMostStride = 1'000'000'000;

void on_signal(int signal) {
  interrupted = signal;
  std::signal(signal, SIG_DFL);
}

// From 1 on, or -1, which is all.
CLI::Validator count_or_all() {
  return CLI::Validator(
      [](std::string& text) {
        if (text == "-1") return std::string();
        const std::string problem = whole_number_from(1)(text);
        return problem.empty() ? problem : problem + ", or -1 for all";
      },
      "FROM 1");
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
  options.skip_bad = skip_bad;
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
  command.add_option("--depth-topic", reading.topics.depth, "depth topic of a bag");
  command.add_option("--first", reading.first, "index of the first frame")->transform(whole_number_from(0));
  command.add_option("--count", reading.count, "frames at most; -1: all")->transform(count_or_all());
  command.add_option("--stride", reading.stride, "every n-th frame")->transform(whole_number_from(1, kMostStride));
  command.add_flag("--skip-bad", reading.skip_bad,
                   "leave out frames without their right image, depth or a stamp that rises, also where they are many");
}

nlohmann::json camera_json(const Camera& camera) {
  static constexpr const char* kModels[] = {"pinhole", "brown_conrady", "kannala_brandt"};
  nlohmann::json json = pinhole_json(camera.pinhole, camera.height);
  json["width"] = camera.width;
  json["height"] = camera.height;
  json["model"] = kModels[static_cast<int>(camera.distortion)];
  if (camera.pinhole.bf > 0) json["baseline"] = camera.pinhole.baseline();
  if (camera.distortion != Distortion::none) json["distortion"] = camera.coefficients;
  return json;
}

void print_json(const nlohmann::json& json) {
  std::cout << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
}

CLI::Validator whole_number_from(int64_t least, int64_t most) {
  return CLI::Validator(
      [least, most](std::string& text) {
        int64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most) {
          text = std::to_string(value);  // a leading 0 would be taken for octal
          return std::string();
        }
        const bool bounded = most < std::numeric_limits<int64_t>::max();
        return text + " is not a whole number from " + std::to_string(least) +
               (bounded ? " to " + std::to_string(most) : " on");
      },
      "FROM " + std::to_string(least) +
          (most < std::numeric_limits<int64_t>::max() ? " TO " + std::to_string(most) : ""));
}

CLI::Validator positive_number() {
  return CLI::Validator(
      [](std::string& text) {
        const auto value = io::parse_double(text);
        return value && *value > 0 ? std::string() : text + " is not a positive number";
      },
      "POSITIVE");
}

Result<void> set_all(const std::vector<std::string>& settings, const Fields& known) {
  std::set<std::string> names;
  for (const std::string& setting : settings) {
    const size_t equals = setting.find('=');
    if (equals == std::string::npos) return fail("--set " + setting + ": it must be NAME=VALUE");
    if (!names.insert(setting.substr(0, equals)).second)
      return fail("--set " + setting + ": " + setting.substr(0, equals) + " is set twice");
    if (auto set = set_field(known, setting.substr(0, equals), setting.substr(equals + 1)); !set) return set;
  }
  return {};
}

Result<void> set_features(int given, const std::vector<std::string>& settings, int& features) {
  const auto sets_them = [](const std::string& setting) { return setting.starts_with("orb.features="); };
  if (given > 0 && given != features && std::ranges::any_of(settings, sets_them))
    return fail("--features " + std::to_string(given) + " and --set orb.features=" + std::to_string(features) +
                " are the same setting; give one of them");
  if (given > 0) features = given;
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
  // A closed terminal; `nohup` has it ignored, and it stays so.
  if (std::signal(SIGHUP, on_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

}  // namespace covis::app
