// SPDX-License-Identifier: Apache-2.0
// covis localize: locates single images, each on its own, in a saved map.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/run/system_input.h"
#include "commands.h"
#include "common.h"
#include "covis/core/atomic_file.h"
#include "covis/core/log.h"
#include "covis/core/quantile.h"
#include "covis/io/output_check.h"
#include "covis/io/sequence.h"
#include "covis/io/trajectory.h"
#include "covis/storage/compatibility.h"
#include "places.h"

namespace covis::app {
namespace {

struct LocalizeArguments {
  std::string path, map, out = "localized.txt", vocabulary;
  Reading reading;
  std::vector<std::string> settings;
  int features = 0;
  bool json = false;
};

struct Found {
  std::vector<Trajectory> of_map;  // poses, grouped by the map they belong to
  int64_t frames = 0, unreadable = 0;
  std::vector<double> times;  // ms
  size_t localized() const {
    size_t all = 0;
    for (const Trajectory& poses : of_map) all += poses.size();
    return all;
  }
};

Found locate_all(io::Sequence& sequence, System& system) {
  Found found;
  const std::shared_ptr<const Snapshot> snapshot = system.snapshot();
  found.of_map.resize(snapshot->submaps.size());
  io::Frame frame;
  while (interrupted == 0) {
    auto next = sequence.next(std::move(frame));
    frame = {};
    if (!next) {
      log(LogLevel::warning, next.error().message);
      ++found.unreadable;
      continue;
    }
    if (!*next) return found;
    frame = std::move(**next);
    ++found.frames;
    const Stopwatch watch;
    const auto located = system.locate(input_of(frame));
    found.times.push_back(watch.ms());
    if (!located) continue;
    if (const auto m = snapshot->index_of(located->submap)) found.of_map[*m].push_back({frame.stamp, located->T_wc});
  }
  return found;
}

void print(const Found& found, const LocalizeArguments& arguments) {
  const double median = quantile(found.times, 0.5);
  if (!arguments.json) {
    std::printf("%zu of %lld images localised, %.1f ms each (median); written to %s\n", found.localized(),
                static_cast<long long>(found.frames), median, arguments.out.c_str());
    return;
  }
  const nlohmann::json summary{{"frames", found.frames},
                               {"localized", found.localized()},
                               {"unreadable", found.unreadable},
                               {"median_ms", median}};
  print_json(summary);
}

// The poses found must not take the place of what they are found with.
Result<void> check_out(const LocalizeArguments& a, const io::Sequence& sequence) {
  const auto truth = sequence.truth();
  auto fits = io::check_trajectories(a.out, {a.path, a.map, a.reading.camera, a.vocabulary, truth ? truth->file : ""});
  return fits ? check_writable(a.out) : fits;
}

int localize(const LocalizeArguments& arguments) {
  SystemOptions options;
  if (const auto set = set_all(arguments.settings, fields(options)); !set) return fail_with(set.error());
  const auto sequence = io::open_sequence(arguments.path, arguments.reading.options());
  if (!sequence) return fail_with(sequence.error());
  if (const auto fits = check_out(arguments, **sequence); !fits) return fail_with(fits.error());
  options.sensor = (*sequence)->sensor();
  options.localize = true;
  const auto features = set_features(arguments.features, arguments.settings, options.orb.features);
  if (!features) return fail_with(features.error());
  const auto vocabulary = open_vocabulary(arguments.vocabulary);
  if (!vocabulary) return fail_with(vocabulary.error());
  auto map = storage::load_compatible_map(
      arguments.map, storage::header_of((*sequence)->camera(), options.sensor, options.orb, vocabulary->get()),
      storage::MapUse::localization);
  if (!map) return fail_with(map.error());
  System system((*sequence)->camera(), options, *vocabulary);
  if (const auto set = system.set_map(std::move(map->map), map->header.camera); !set)
    return fail_with(arguments.map + ": " + set.error().message);

  end_well_on_signals();
  const Found found = locate_all(**sequence, system);
  if (interrupted != 0 && found.localized() == 0) {
    fail_with("interrupted before an image was localised; nothing is written");
    return 128 + interrupted;
  }
  if (found.frames == 0) return fail_with(arguments.path + ": no frame could be read");
  const auto saved = io::write_trajectories(arguments.out, found.of_map, io::TrajectoryFormat::tum);
  if (!saved) return fail_with(saved.error());
  print(found, arguments);
  if (interrupted == 0) return 0;
  log(LogLevel::warning, "interrupted; the poses found so far are written");
  return 128 + interrupted;
}

}  // namespace
}  // namespace covis::app

void add_localize_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto arguments = std::make_shared<LocalizeArguments>();
  CLI::App* command = app.add_subcommand("localize", "Locate single images in a saved map, each on its own");
  command->add_option("PATH", arguments->path, "images: a recording's folder or a video")->required();
  command->add_option("--map", arguments->map, "saved map (covis run --save-map)")->required();
  command->add_option("--out", arguments->out, "poses found, TUM format, in the map's world")->capture_default_str();
  add_reading_options(*command, arguments->reading);
  command->add_option("--vocabulary", arguments->vocabulary, "vocabulary (default: the one that ships)");
  command->add_option("--features", arguments->features, "keypoints an image")->transform(whole_number_from(50, 30000));
  command->add_option("--set", arguments->settings, "one setting, NAME=VALUE; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--json", arguments->json, "the summary as JSON on stdout");
  command->footer("Examples:\n  covis localize office2 --map office.m --out found.txt");
  command->callback([arguments, &exit_code] { exit_code = localize(*arguments); });
}
