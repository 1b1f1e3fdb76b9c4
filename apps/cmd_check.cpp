// SPDX-License-Identifier: Apache-2.0
// covis check: what a recording is, and what is wrong with it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "check_picture.h"
#include "commands.h"
#include "covis/core/log.h"
#include "covis/io/sequence.h"

namespace covis::app {
namespace {

struct CheckArguments {
  std::string path, sensor, camera, out = "check.png";
  int64_t count = -1;
  bool json = false;
};

struct Problem {
  int64_t frame = 0;
  std::string text;
};

const std::map<std::string, Sensor> kSensors{
    {"mono", Sensor::monocular}, {"stereo", Sensor::stereo}, {"rgbd", Sensor::rgbd}};

double mean_grey(const ImageU8& image) {
  int64_t sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) sum += image(x, y);
  }
  return static_cast<double>(sum) / image.width() / image.height();
}

double depth_share(const ImageF& depth) {
  int64_t valid = 0;
  for (int y = 0; y < depth.height(); ++y)
    valid += std::count_if(depth.row(y), depth.row(y) + depth.width(), [](float d) { return d > 0; });
  return static_cast<double>(valid) / depth.width() / depth.height();
}

// What a frame lacks that can be seen without tracking it.
void look_at(const io::Frame& frame, std::vector<Problem>& problems) {
  const double grey = mean_grey(frame.image);
  if (grey < 8)
    problems.push_back(
        {frame.index, "the image is nearly black (mean grey level " + std::to_string(static_cast<int>(grey)) + ")"});
  if (grey > 247) problems.push_back({frame.index, "the image is nearly white"});
  if (!frame.depth.empty() && depth_share(frame.depth) < 0.02)
    problems.push_back({frame.index, "the depth image is nearly empty"});
}

// Gaps of more than twice and a half the usual step.
void look_for_gaps(const std::vector<Timestamp>& stamps, double rate, std::vector<Problem>& problems,
                   const std::vector<int64_t>& frames) {
  for (size_t i = 1; i < stamps.size(); ++i) {
    const double gap = to_seconds(stamps[i] - stamps[i - 1]);
    if (gap * rate > 2.5)
      problems.push_back({frames[i], "comes " + std::to_string(gap) + " s after the frame before it"});
  }
}

nlohmann::json camera_json(const Camera& c) {
  const char* models[] = {"pinhole", "brown_conrady", "kannala_brandt"};
  nlohmann::json json{{"width", c.width},
                      {"height", c.height},
                      {"fx", c.pinhole.fx},
                      {"fy", c.pinhole.fy},
                      {"cx", c.pinhole.cx},
                      {"cy", c.pinhole.cy},
                      {"model", models[static_cast<int>(c.distortion)]}};
  if (c.pinhole.bf > 0) json["baseline"] = c.pinhole.baseline();
  if (c.distortion != Distortion::none) json["distortion"] = c.coefficients;
  return json;
}

void print(const nlohmann::json& found) {
  std::cout << found["recording"].get<std::string>() << "\n";
  std::printf("frames read     %lld, %lld unreadable\n", found["frames_read"].get<long long>(),
              found["frames_unreadable"].get<long long>());
  std::printf("rate            %.2f Hz, %.2f s in all\n", found["rate_hz"].get<double>(),
              found["seconds"].get<double>());
  std::cout << "camera          " << found["camera"].dump() << "\n";
  std::cout << "truth           " << (found["truth"].get<bool>() ? "yes" : "no") << "\n";
  for (const auto& problem : found["problems"]) {
    std::printf("frame %-9lld %s\n", problem["frame"].get<long long>(), problem["problem"].get<std::string>().c_str());
  }
  std::printf("%zu problems\n", found["problems"].size());
}

int run(const CheckArguments& a) {
  io::SequenceOptions options;
  if (!a.sensor.empty()) options.sensor = kSensors.at(a.sensor);
  options.camera_file = a.camera;
  options.count = a.count;
  auto opened = io::open_sequence(a.path, options);
  if (!opened) {
    log(LogLevel::error, opened.error().message);
    return 1;
  }
  io::Sequence& sequence = **opened;
  CheckPicture picture(sequence.camera(), sequence.sensor());
  std::vector<Problem> problems;
  std::vector<Timestamp> stamps;
  std::vector<int64_t> frames;
  int64_t unreadable = 0, expected = 0;
  io::Frame frame;
  while (true) {
    auto next = sequence.next(std::move(frame));
    frame = {};
    if (!next) {
      ++unreadable;
      problems.push_back({expected++, next.error().message});
      continue;
    }
    if (!*next) break;
    frame = std::move(**next);
    expected = frame.index + 1;
    stamps.push_back(frame.stamp);
    frames.push_back(frame.index);
    look_at(frame, problems);
    const int64_t size = sequence.size() > 0 ? sequence.size() : 300;
    if (frame.index % std::max<int64_t>(1, size / CheckPicture::kFrames) == 0) picture.add(frame);
  }
  look_for_gaps(stamps, sequence.frame_rate(), problems, frames);
  nlohmann::json found{{"recording", sequence.description()},
                       {"frames_read", stamps.size()},
                       {"frames_unreadable", unreadable},
                       {"rate_hz", sequence.frame_rate()},
                       {"seconds", stamps.empty() ? 0 : to_seconds(stamps.back() - stamps.front())},
                       {"camera", camera_json(sequence.camera())},
                       {"truth", sequence.truth().has_value()},
                       {"picture", a.out}};
  found["problems"] = nlohmann::json::array();
  for (const Problem& problem : problems)
    found["problems"].push_back({{"frame", problem.frame}, {"problem", problem.text}});
  if (a.json) {
    std::cout << found.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
  } else {
    print(found);
  }
  if (!stamps.empty()) {
    if (auto written = picture.write(a.out); !written) {
      log(LogLevel::error, written.error().message);
      return 1;
    }
    if (!a.json) std::cout << picture.caption() << ": " << a.out << "\n";
  }
  return problems.empty() && !stamps.empty() ? 0 : 1;
}

}  // namespace
}  // namespace covis::app

void add_check_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto a = std::make_shared<CheckArguments>();
  CLI::App* command = app.add_subcommand("check", "Say what a recording is and what is wrong with it, with a picture");
  command->add_option("PATH", a->path, "folder (TUM RGB-D, KITTI, EuRoC, images), video file, or camera number")
      ->required();
  command->add_option("--sensor", a->sensor, "mono, stereo or rgbd (default: the richest the recording allows)")
      ->check(CLI::IsMember(std::vector<std::string>{"mono", "stereo", "rgbd"}));
  command->add_option("--camera", a->camera, "camera YAML, for what the recording does not say");
  command->add_option("--count", a->count, "frames at most");
  command->add_option("--out", a->out, "the picture: stereo rows, depth overlay, or key points")->capture_default_str();
  command->add_flag("--json", a->json, "JSON on stdout");
  command->footer(
      "Examples:\n  covis check rgbd_dataset_freiburg1_desk\n  covis check kitti/sequences/06 --out rows.png\nExit "
      "code 1 when there is a problem.");
  command->callback([a, &exit_code] { exit_code = run(*a); });
}
