// SPDX-License-Identifier: Apache-2.0
// covis map: describes a saved map, checks its integrity, and writes it for other programs.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/run/run_json.h"
#include "commands.h"
#include "common.h"
#include "covis/core/sensor.h"
#include "covis/io/output_check.h"
#include "covis/storage/map_file.h"
#include "map_export.h"
#include "map_import.h"
#include "map_merge.h"
#include "map_picture.h"
#include "map_prune.h"

namespace covis::app {
namespace {

struct MapArguments {
  std::string file, picture;
  bool json = false;
};

nlohmann::json to_json(const std::vector<storage::OtherCamera>& cameras) {
  nlohmann::json list = nlohmann::json::array();
  for (const storage::OtherCamera& camera : cameras)
    list.push_back({{"camera", camera_json(camera.given)}, {"key_frames", camera.key_frames}});
  return list;
}

bool in_metres(const storage::MapInfo& info) { return io::unit_of(info.header.sensor) == io::CloudUnit::metres; }

nlohmann::json to_json(const std::string& file, const storage::MapInfo& info) {
  return {{"file", file},
          {"version", std::to_string(info.major) + "." + std::to_string(info.minor)},
          {"bytes", info.file_size},
          {"sensor", name(info.header.sensor)},
          {"camera", camera_json(info.header.camera)},
          {"refined", pinhole_json(info.camera, info.header.camera.height)},
          {"other_cameras", to_json(info.other_cameras)},
          {"pyramid", {{"levels", info.header.levels}, {"factor", info.header.factor}}},
          {"vocabulary", info.header.vocabulary},
          {"maps", info.submaps},
          {"key_frames", info.key_frames},
          {"points", info.points},
          {"observations", info.observations},
          {"features", info.features},
          {in_metres(info) ? "extent_m" : "extent_units", {info.extent.x(), info.extent.y(), info.extent.z()}},
          {"seconds", info.seconds}};
}

void print(const std::string& file, const storage::MapInfo& info, const nlohmann::json& json) {
  std::cout << file << "\n";
  std::printf("version         %d.%d\n", info.major, info.minor);
  std::printf("size            %.2f MB\n", static_cast<double>(info.file_size) / 1e6);
  std::cout << "sensor          " << json["sensor"].get<std::string>() << "\n";
  std::cout << "camera          " << json["camera"].dump() << "\n";
  if (info.camera.fx != info.header.camera.pinhole.fx || info.camera.residual.any() || info.camera.registration.any() ||
      info.camera.row_time != 0)
    std::cout << "refined to      " << json["refined"].dump() << "\n";
  for (const storage::OtherCamera& camera : info.other_cameras) {
    std::cout << "other camera    " << camera_json(camera.given).dump() << ", of " << camera.key_frames
              << " key frames\n";
  }
  std::printf("pyramid         %d levels, factor %g\n", info.header.levels, static_cast<double>(info.header.factor));
  std::cout << "vocabulary      " << (info.header.vocabulary.empty() ? "none" : info.header.vocabulary) << "\n";
  if (info.submaps > 1)
    std::printf("maps            %llu, not joined\n", static_cast<unsigned long long>(info.submaps));
  std::printf("key frames      %llu, over %.2f s\n", static_cast<unsigned long long>(info.key_frames), info.seconds);
  std::printf("points          %llu, seen %llu times\n", static_cast<unsigned long long>(info.points),
              static_cast<unsigned long long>(info.observations));
  std::printf("extent          %.2f x %.2f x %.2f %s\n", info.extent.x(), info.extent.y(), info.extent.z(),
              in_metres(info) ? "m" : "units of the map (of one camera: no metres)");
}

int run_info(const MapArguments& a) {
  if (!a.picture.empty()) {
    const auto fits = io::check_output(a.picture, io::OutputKind::picture, {a.file});
    if (!fits) return fail_with(fits.error());
  }
  const auto info = storage::read_map_info(a.file);
  if (!info) return fail_with(info.error());
  if (!a.picture.empty()) {
    const auto loaded = storage::load_map(a.file);
    if (!loaded) return fail_with(loaded.error());
    const auto plots = plots_from_above(loaded->map, loaded->header.camera, a.file);
    if (const auto written = write_plots(a.picture, plots); !written) return fail_with(written.error());
  }
  const nlohmann::json json = to_json(a.file, *info);
  if (a.json) {
    print_json(json);
  } else {
    print(a.file, *info, json);
  }
  return 0;
}

int run_check(const MapArguments& a) {
  const auto loaded = storage::load_map(a.file);
  if (!loaded) return fail_with(loaded.error());
  std::cout << a.file << ": whole\n";
  return 0;
}

}  // namespace
}  // namespace covis::app

void add_map_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto a = std::make_shared<MapArguments>();
  CLI::App* command = app.add_subcommand(
      "map", "Describe, check, import, merge, prune or split saved maps, or write them for other programs");
  command->require_subcommand(1);
  CLI::App* info = command->add_subcommand("info", "Version, camera, sensor, counts, extent, duration and size");
  info->add_option("FILE", a->file, "a saved map")->required();
  info->add_flag("--json", a->json, "JSON on stdout");
  info->add_option("--picture", a->picture, "PNG file for a picture of the map from above");
  info->callback([a, &exit_code] { exit_code = run_info(*a); });
  CLI::App* check = command->add_subcommand("check", "Load the map, check all of it, and report what is wrong");
  check->add_option("FILE", a->file, "a saved map")->required();
  check->callback([a, &exit_code] { exit_code = run_check(*a); });
  add_map_export(*command, exit_code);
  add_map_import(*command, exit_code);
  add_map_merge(*command, exit_code);
  add_map_prune(*command, exit_code);
  add_map_split(*command, exit_code);
  command->footer(
      "Examples:\n  covis map info office.covis --picture office.png\n  covis map check office.covis\n"
      "  covis map export office.covis --to colmap --out office_colmap\n"
      "  covis map import sparse/0 --images images --out office.covis\n"
      "  covis map merge monday.m tuesday.m --out site.m\n"
      "  covis map prune site.m --key-frames 300 --out small.m\n"
      "  covis map split site.m --around 0,0,0,10 --out parts\n"
      "Exit code 1 when the file can't be read or is not whole.");
}
