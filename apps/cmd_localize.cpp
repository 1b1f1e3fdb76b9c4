// SPDX-License-Identifier: Apache-2.0
// covis localize: where single images were taken, each on its own, in a saved map.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "common.h"
#include "covis/core/log.h"
#include "covis/io/files.h"
#include "covis/io/sequence.h"
#include "covis/io/trajectory.h"
#include "places.h"

namespace covis::app {
namespace {

struct LocalizeArguments {
  std::string path, map, out = "localized.txt", sensor, camera, vocabulary;
  int64_t first = 0, count = -1;
  int stride = 1, features = 0;
  bool json = false;
};

// A saved map may have several that are not joined, each with a world of its own: found.txt, found_map1.txt, …
std::filesystem::path file_of_map(const std::filesystem::path& out, size_t map) {
  if (map == 0) return out;
  std::filesystem::path file = out;
  file.replace_filename(out.stem().string() + "_map" + std::to_string(map) + out.extension().string());
  return file;
}

int localize(const LocalizeArguments& arguments) {
  io::SequenceOptions reading;
  if (!arguments.sensor.empty()) reading.sensor = kSensors.at(arguments.sensor);
  reading.camera_file = arguments.camera;
  reading.first = arguments.first;
  reading.count = arguments.count;
  reading.stride = arguments.stride;
  auto sequence = io::open_sequence(arguments.path, reading);
  if (!sequence) return fail_with(sequence.error());
  SystemOptions options;
  options.sensor = (*sequence)->sensor();
  options.localize = true;
  if (arguments.features > 0) options.orb.features = arguments.features;
  const auto vocabulary = open_vocabulary(arguments.vocabulary);
  if (!vocabulary) return fail_with(vocabulary.error());
  auto map = open_map(arguments.map, options);
  if (!map) return fail_with(map.error());
  System system((*sequence)->camera(), options, *vocabulary);
  system.set_map(std::move(*map));

  std::vector<Trajectory> found(system.maps().size());  // of each map
  int64_t frames = 0, unreadable = 0;
  std::vector<double> times;
  io::Frame frame;
  while (true) {
    auto next = (*sequence)->next(std::move(frame));
    frame = {};
    if (!next) {
      log(LogLevel::warning, next.error().message);
      ++unreadable;
      continue;
    }
    if (!*next) break;
    frame = std::move(**next);
    ++frames;
    const Stopwatch watch;
    const auto located = system.locate({.frame = frame.index,
                                        .stamp = frame.stamp,
                                        .image = frame.image.view(),
                                        .right = frame.right.view(),
                                        .depth = frame.depth.view()});
    times.push_back(watch.ms());
    if (located) found[static_cast<size_t>(located->map)].push_back({frame.stamp, located->T_wc});
  }
  if (frames == 0) return fail_with(arguments.path + ": no frame could be read");
  size_t localized = 0;
  for (size_t m = 0; m < found.size(); ++m) {
    localized += found[m].size();
    const std::filesystem::path file = file_of_map(arguments.out, m);
    if (const auto saved = io::write_trajectory(file, found[m], io::TrajectoryFormat::tum); !saved)
      return fail_with(saved.error());
  }
  std::nth_element(times.begin(), times.begin() + static_cast<ptrdiff_t>(times.size() / 2), times.end());
  const double median = times[times.size() / 2];
  if (arguments.json) {
    std::cout << nlohmann::json{{"frames", frames},
                                {"localized", localized},
                                {"unreadable", unreadable},
                                {"median_ms", median}}
                     .dump(2)
              << "\n";
  } else {
    std::printf("%zu of %lld images localised, %.1f ms each (median); written to %s\n", localized,
                static_cast<long long>(frames), median, arguments.out.c_str());
  }
  return 0;
}

}  // namespace
}  // namespace covis::app

void add_localize_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto arguments = std::make_shared<LocalizeArguments>();
  CLI::App* command = app.add_subcommand("localize", "Find single images in a saved map, each from nothing");
  command->add_option("PATH", arguments->path, "images: a recording's folder or a video")->required();
  command->add_option("--map", arguments->map, "saved map (covis run --save-map)")->required();
  command->add_option("--out", arguments->out, "poses found, TUM format, in the map's world")->capture_default_str();
  command->add_option("--sensor", arguments->sensor, "mono, stereo or rgbd")->check(CLI::IsMember(keys(kSensors)));
  command->add_option("--camera", arguments->camera, "camera YAML, for what the recording does not say");
  command->add_option("--vocabulary", arguments->vocabulary, "vocabulary (default: the one that comes along)");
  command->add_option("--features", arguments->features, "key points an image")->check(CLI::Range(50, 30000));
  command->add_option("--first", arguments->first, "index of the first image")->check(CLI::NonNegativeNumber);
  command->add_option("--count", arguments->count, "images at most");
  command->add_option("--stride", arguments->stride, "every n-th image")->check(CLI::PositiveNumber);
  command->add_flag("--json", arguments->json, "the summary as JSON on stdout");
  command->footer("Examples:\n  covis localize office2 --map office.m --out found.txt");
  command->callback([arguments, &exit_code] { exit_code = localize(*arguments); });
}
