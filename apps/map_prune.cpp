// SPDX-License-Identifier: Apache-2.0
#include "map_prune.h"

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "common.h"
#include "covis/core/quantile.h"
#include "covis/io/files.h"
#include "covis/io/output_check.h"
#include "covis/map/camera_change.h"
#include "covis/mapping/map_area.h"
#include "covis/mapping/map_thinning.h"
#include "covis/storage/map_file.h"
#include "covis/tracking/relocaliser.h"
#include "places.h"

namespace covis::app {
namespace {

constexpr size_t kAll = size_t{1} << 30;

struct PruneArguments {
  std::string file, out, vocabulary;
  size_t key_frames = kAll, points = kAll;
  bool json = false;
};

// Views looked for in the map that is left.
struct PruningCost {
  size_t asked = 0, found = 0;
  double median = 0;  // distance from where they were, in the map's unit
};

PruningCost cost_of(const SharedMap& map, const std::vector<ThinnedKeyFrame>& views,
                    const std::shared_ptr<const Vocabulary>& vocabulary) {
  PruningCost cost{.asked = views.size()};
  Relocaliser relocaliser(map, {}, 0, vocabulary);
  std::vector<double> off;
  for (const ThinnedKeyFrame& view : views) {
    const auto located = relocaliser.locate(view.features, view.frame);
    if (!located || located->submap != view.submap) continue;
    off.push_back((located->T_cw.centre() - view.T_cw.centre()).norm());
  }
  cost.found = off.size();
  cost.median = quantile(std::move(off), 0.5);
  return cost;
}

std::vector<ThinnedKeyFrame> views_of(const Map& map) {
  std::vector<ThinnedKeyFrame> views;
  for (const KeyFrameId& id : map.key_frames()) {
    const KeyFrame& key_frame = map.at(id);
    views.push_back({key_frame.frame, key_frame.T_cw, key_frame.submap, key_frame.features});
  }
  return views;
}

int run_prune(const PruneArguments& a) {
  if (const auto other = io::check_other_file(a.out, {a.file}); !other) return fail_with(other.error());
  if (const auto fits = storage::check_save_target(a.out); !fits) return fail_with(fits.error());
  const auto vocabulary = open_vocabulary(a.vocabulary);
  if (!vocabulary) return fail_with(vocabulary.error());
  auto loaded = storage::load_map(a.file);
  if (!loaded) return fail_with(loaded.error());
  const size_t key_frames = loaded->map.key_frame_count(), points = loaded->map.point_count();
  const std::vector<ThinnedKeyFrame> erased = thin_map(loaded->map, a.key_frames);
  const bool points_too = a.points < loaded->map.point_count();
  if (points_too) thin_points(loaded->map, a.points);
  if (const auto saved = storage::save_map(a.out, loaded->map.state(), loaded->header); !saved)
    return fail_with(saved.error());
  if (*vocabulary) {
    for (const KeyFrameId& id : loaded->map.key_frames()) {
      const auto& descriptors = loaded->map.at(id).features->descriptor;
      loaded->map.set_words(id, std::make_shared<const Words>((*vocabulary)->transform(descriptors)));
    }
  }
  SharedMap map;
  *map.write() = std::move(loaded->map);
  const PruningCost cost = cost_of(map, erased, *vocabulary);
  const PruningCost left = points_too ? cost_of(map, views_of(*map.read()), *vocabulary) : PruningCost{};
  const size_t key_frames_left = map.read()->key_frame_count(), points_left = map.read()->point_count();
  std::error_code ignored;
  const auto bytes = std::filesystem::file_size(a.file, ignored),
             bytes_left = std::filesystem::file_size(a.out, ignored);
  if (a.json) {
    nlohmann::json json{{"out", a.out},
                        {"key_frames", {key_frames, key_frames_left}},
                        {"points", {points, points_left}},
                        {"bytes", {bytes, bytes_left}},
                        {"views_taken_out", cost.asked},
                        {"found_again", cost.found},
                        {"median_distance", cost.median}};
    if (points_too) {
      json["views_left"] = left.asked;
      json["left_found_again"] = left.found;
      json["left_median_distance"] = left.median;
    }
    print_json(json);
    return 0;
  }
  std::printf("key frames      %zu of %zu\npoints          %zu of %zu\nsize            %.2f of %.2f MB\n",
              key_frames_left, key_frames, points_left, points, static_cast<double>(bytes_left) / 1e6,
              static_cast<double>(bytes) / 1e6);
  const auto print = [](const char* views, const PruningCost& of) {
    std::printf("%-15s %zu, of which %zu are found in the map that is left, %.3g m off (median)\n", views, of.asked,
                of.found, of.median);
  };
  if (a.key_frames < key_frames) print("views taken out", cost);
  if (points_too) print("views left", left);
  return 0;
}

struct SplitArguments {
  std::string file, out;
  std::vector<std::string> around, boxes;
};

// `kind`: area or map, which the k-th file's name begins with.
std::filesystem::path part_file(const SplitArguments& a, const std::string& kind, size_t k) {
  return std::filesystem::path(a.out) / (kind + std::to_string(k) + ".m");
}

// Makes the folder. Error: one of the parts can't be saved there.
Result<void> open_parts(const SplitArguments& a, const std::string& kind, size_t count) {
  std::error_code error;
  std::filesystem::create_directories(a.out, error);
  if (error) return fail(a.out + ": " + error.message());
  for (size_t k = 0; k < count; ++k) {
    const std::filesystem::path file = part_file(a, kind, k);
    if (auto other = io::check_other_file(file, {a.file}); !other) return other;
    if (auto fits = storage::check_save_target(file); !fits) return fits;
  }
  return {};
}

Result<void> save_part(const std::filesystem::path& file, const Map& part, const storage::MapHeader& header) {
  storage::MapHeader of_part = header;
  if (metric_submaps(part).empty()) of_part.sensor = Sensor::monocular;
  if (auto saved = storage::save_map(file, part.state(), of_part); !saved) return saved;
  std::printf("%s: %zu key frames, %zu points\n", file.c_str(), part.key_frame_count(), part.point_count());
  return {};
}

Result<void> split_by_maps(const SplitArguments& a, const storage::SavedMap& loaded) {
  const std::vector<Submap> submaps = loaded.map.submaps();
  if (auto opened = open_parts(a, "map", submaps.size()); !opened) return opened;
  for (size_t k = 0; k < submaps.size(); ++k) {
    auto part = Map::from_state(loaded.map.state());
    if (!part) return tl::unexpected(part.error());
    for (size_t other = 0; other < submaps.size(); ++other) {
      if (other != k) part->erase_submap(part->submaps()[other < k ? 0 : 1].id);
    }
    if (auto saved = save_part(part_file(a, "map", k), *part, loaded.header); !saved) return saved;
  }
  return {};
}

using Area = std::function<bool(const Eigen::Vector3d&)>;

// As many numbers as asked for, with commas between them.
Result<Eigen::VectorXd> numbers(const std::string& option, const std::string& text, Eigen::Index count) {
  const auto wrong = [&] {
    return fail(option + " " + text + ": it must be " + std::to_string(count) + " numbers with commas between them");
  };
  if (std::count(text.begin(), text.end(), ',') != count - 1) return wrong();
  Eigen::VectorXd values(count);
  std::istringstream in(text);
  std::string word;
  for (double& value : values) {
    std::getline(in, word, ',');
    const auto number = io::parse_double(word);
    if (!number || !std::isfinite(*number)) return wrong();
    value = *number;
  }
  return values;
}

Result<std::vector<Area>> areas_of(const SplitArguments& a) {
  std::vector<Area> areas;
  for (const std::string& text : a.around) {
    const auto v = numbers("--around", text, 4);
    if (!v) return tl::unexpected(v.error());
    if (!((*v)[3] > 0))
      return fail("--around " + text + ": the fourth number is a radius, which must be greater than 0");
    const Eigen::Vector3d centre = v->head<3>();
    areas.emplace_back([centre, radius = (*v)[3]](const Eigen::Vector3d& p) { return (p - centre).norm() <= radius; });
  }
  for (const std::string& text : a.boxes) {
    const auto v = numbers("--box", text, 6);
    if (!v) return tl::unexpected(v.error());
    const Eigen::AlignedBox3d box(v->head<3>().cwiseMin(v->tail<3>()), v->head<3>().cwiseMax(v->tail<3>()));
    areas.emplace_back([box](const Eigen::Vector3d& p) { return box.contains(p); });
  }
  return areas;
}

Result<void> split_by_areas(const SplitArguments& a, const std::vector<Area>& areas, const storage::SavedMap& loaded) {
  std::deque<Map> parts;  // all of them before one is written: an area may hold nothing
  for (size_t k = 0; k < areas.size(); ++k) {
    auto part = part_of(loaded.map, areas[k]);
    if (!part) return fail(a.file + ": area " + std::to_string(k) + ": " + part.error().message);
    parts.push_back(std::move(*part));
  }
  if (auto opened = open_parts(a, "area", parts.size()); !opened) return opened;
  for (size_t k = 0; k < parts.size(); ++k) {
    if (auto saved = save_part(part_file(a, "area", k), parts[k], loaded.header); !saved) return saved;
  }
  return {};
}

int run_split(const SplitArguments& a) {
  const auto areas = areas_of(a);
  if (!areas) return fail_with(areas.error());
  const auto loaded = storage::load_map(a.file);
  if (!loaded) return fail_with(loaded.error());
  const Result<void> done = areas->empty() ? split_by_maps(a, *loaded) : split_by_areas(a, *areas, *loaded);
  return done ? 0 : fail_with(done.error());
}

}  // namespace

void add_map_prune(CLI::App& map_command, int& exit_code) {
  auto a = std::make_shared<PruneArguments>();
  CLI::App* command = map_command.add_subcommand("prune", "Leave out the key frames or points whose loss costs least");
  command->add_option("FILE", a->file, "a saved map")->required();
  CLI::Option_group* budget = command->add_option_group("budget", "at least one");
  budget->add_option("--key-frames", a->key_frames, "so many are left (at least one of each map)")
      ->transform(whole_number_from(1, kAll));
  budget->add_option("--points", a->points, "so many are left at most")->transform(whole_number_from(1, kAll));
  budget->require_option(1, 2);
  command->add_option("--out", a->out, "file for the smaller map")->required();
  command->add_option("--vocabulary", a->vocabulary, "to look for what was taken out (default: the one that ships)");
  command->add_flag("--json", a->json, "JSON on stdout");
  command->callback([a, &exit_code] { exit_code = run_prune(*a); });
}

void add_map_split(CLI::App& map_command, int& exit_code) {
  auto a = std::make_shared<SplitArguments>();
  CLI::App* command = map_command.add_subcommand("split", "Write parts of a map by themselves");
  command->add_option("FILE", a->file, "a saved map")->required();
  command->add_option("--out", a->out, "folder for the parts")->required();
  command->add_option("--around", a->around, "the key frames within R metres of a point, as X,Y,Z,R; may be repeated");
  command->add_option("--box", a->boxes, "those in a box between two corners, as X,Y,Z,X,Y,Z; may be repeated");
  command->footer(
      "Without an area: each of the maps of a file that are not joined, as map0.m, map1.m, …\nWith areas: what lies in "
      "each, as area0.m, area1.m, …; areas may overlap. Positions are those of cameras in the map's world.\nExample:\n"
      "  covis map split site.m --around 0,0,0,10 --around 12,0,3,10 --out parts");
  command->callback([a, &exit_code] { exit_code = run_split(*a); });
}

}  // namespace covis::app
