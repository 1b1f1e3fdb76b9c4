// SPDX-License-Identifier: Apache-2.0
#include "map_prune.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common.h"
#include "covis/core/quantile.h"
#include "covis/mapping/map_thinning.h"
#include "covis/storage/map_file.h"
#include "covis/tracking/relocaliser.h"
#include "places.h"

namespace covis::app {
namespace {

struct PruneArguments {
  std::string file, out, vocabulary;
  size_t key_frames = 0;
  bool json = false;
};

// The views that were taken out, looked for in the map that is left.
struct PruningCost {
  size_t asked = 0, found = 0;
  double median = 0;  // distance from where they were, in the map's unit
};

PruningCost cost_of(const SharedMap& map, const std::vector<ThinnedKeyFrame>& erased,
                    const std::shared_ptr<const Vocabulary>& vocabulary) {
  PruningCost cost{.asked = erased.size()};
  Relocaliser relocaliser(map, {}, 0, vocabulary);
  std::vector<double> off;
  for (const ThinnedKeyFrame& view : erased) {
    const auto located = relocaliser.locate(view.features, view.frame, {});
    if (!located || located->submap != view.submap) continue;
    off.push_back((located->T_cw.centre() - view.T_cw.centre()).norm());
  }
  cost.found = off.size();
  cost.median = quantile(std::move(off), 0.5);
  return cost;
}

int run_prune(const PruneArguments& a) {
  if (const auto other = check_other_file(a.out, {a.file}); !other) return fail_with(other.error());
  if (const auto fits = storage::check_save_target(a.out); !fits) return fail_with(fits.error());
  const auto vocabulary = open_vocabulary(a.vocabulary);
  if (!vocabulary) return fail_with(vocabulary.error());
  auto loaded = storage::load_map(a.file);
  if (!loaded) return fail_with(loaded.error());
  const size_t key_frames = loaded->map.key_frame_count(), points = loaded->map.point_count();
  const std::vector<ThinnedKeyFrame> erased = thin_map(loaded->map, a.key_frames);
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
  const size_t key_frames_left = map.read()->key_frame_count(), points_left = map.read()->point_count();
  std::error_code ignored;
  const auto bytes = std::filesystem::file_size(a.file, ignored),
             bytes_left = std::filesystem::file_size(a.out, ignored);
  if (a.json) {
    const nlohmann::json json{{"out", a.out},
                              {"key_frames", {key_frames, key_frames_left}},
                              {"points", {points, points_left}},
                              {"bytes", {bytes, bytes_left}},
                              {"views_taken_out", cost.asked},
                              {"found_again", cost.found},
                              {"median_distance", cost.median}};
    print_json(json);
    return 0;
  }
  std::printf("key frames      %zu of %zu\npoints          %zu of %zu\nsize            %.2f of %.2f MB\n",
              key_frames_left, key_frames, points_left, points, static_cast<double>(bytes_left) / 1e6,
              static_cast<double>(bytes) / 1e6);
  std::printf("views taken out %zu, of which %zu are found in the map that is left, %.3g m off (median)\n", cost.asked,
              cost.found, cost.median);
  return 0;
}

struct SplitArguments {
  std::string file, out;
};

int run_split(const SplitArguments& a) {
  const auto loaded = storage::load_map(a.file);
  if (!loaded) return fail_with(loaded.error());
  std::error_code error;
  std::filesystem::create_directories(a.out, error);
  if (error) return fail_with(a.out + ": " + error.message());
  const std::vector<Submap> submaps = loaded->map.submaps();
  for (size_t k = 0; k < submaps.size(); ++k) {
    auto part = Map::from_state(loaded->map.state());
    if (!part) return fail_with(part.error());
    for (size_t other = 0; other < submaps.size(); ++other) {
      if (other != k) part->erase_submap(part->submaps()[other < k ? 0 : 1].id);
    }
    const std::filesystem::path file = std::filesystem::path(a.out) / ("map" + std::to_string(k) + ".m");
    if (const auto saved = storage::save_map(file, part->state(), loaded->header); !saved)
      return fail_with(saved.error());
    std::printf("%s: %zu key frames, %zu points\n", file.c_str(), part->key_frame_count(), part->point_count());
  }
  return 0;
}

}  // namespace

void add_map_prune(CLI::App& map_command, int& exit_code) {
  auto a = std::make_shared<PruneArguments>();
  CLI::App* command = map_command.add_subcommand("prune", "Leave out the key frames whose loss costs least");
  command->add_option("FILE", a->file, "a saved map")->required();
  command->add_option("--key-frames", a->key_frames, "so many are left (at least one of each map)")
      ->required()
      ->check(CLI::Range(size_t{1}, size_t{1} << 30));
  command->add_option("--out", a->out, "file for the smaller map")->required();
  command->add_option("--vocabulary", a->vocabulary, "to look for what was taken out (default: the one that ships)");
  command->add_flag("--json", a->json, "JSON on stdout");
  command->callback([a, &exit_code] { exit_code = run_prune(*a); });
}

void add_map_split(CLI::App& map_command, int& exit_code) {
  auto a = std::make_shared<SplitArguments>();
  CLI::App* command = map_command.add_subcommand("split", "Write each map of a file that are not joined by itself");
  command->add_option("FILE", a->file, "a saved map")->required();
  command->add_option("--out", a->out, "folder for map0.m, map1.m, …")->required();
  command->callback([a, &exit_code] { exit_code = run_split(*a); });
}

}  // namespace covis::app
