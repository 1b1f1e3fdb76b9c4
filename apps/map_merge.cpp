// SPDX-License-Identifier: Apache-2.0
#include "map_merge.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common.h"
#include "covis/core/log.h"
#include "covis/exchange/kept_images.h"
#include "covis/io/output_check.h"
#include "covis/loops/map_merging.h"
#include "covis/storage/compatibility.h"
#include "covis/storage/map_file.h"
#include "merged_images.h"
#include "places.h"

namespace covis::app {
namespace {

struct MergeArguments {
  std::vector<std::string> files, settings;
  std::string out, vocabulary;
  bool json = false, keep_images = false;
};

// A setting that merging does not ask for must not seem to have an effect.
Result<void> set_loops(const std::vector<std::string>& settings, LoopOptions& options) {
  const Fields asked_for = merge_fields(options);
  const auto knows = [](const Fields& known, std::string_view name) {
    return std::ranges::find(known, name, &Field::name) != known.end();
  };
  for (const std::string& setting : settings) {
    const std::string_view name = std::string_view(setting).substr(0, setting.find('='));
    if (knows(asked_for, name) || !knows(fields(options), name)) continue;
    std::string others;
    for (const Field& field : asked_for) others += (others.empty() ? "" : ", ") + field.name;
    return fail("--set " + setting + ": maps are merged without asking for it; what they ask for: " + others);
  }
  return set_all(settings, asked_for);
}

// The inputs must be left as they are, and none may count twice. The result must have a place before it is made.
Result<void> check_files(const MergeArguments& a) {
  std::error_code ignored;
  if (auto other = io::check_other_file(a.out, {a.files.begin(), a.files.end()}); !other) return other;
  for (size_t i = 0; i < a.files.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (std::filesystem::equivalent(a.files[i], a.files[j], ignored)) return fail(a.files[i] + ": given twice");
    }
  }
  return storage::check_save_target(a.out);
}

struct Inputs {
  std::vector<storage::MapHeader> headers;
  std::vector<MergeSource> maps;
};

Result<Inputs> load(const std::vector<std::string>& files) {
  Inputs inputs;
  for (const std::string& file : files) {
    auto loaded = storage::load_map(file);
    if (!loaded) return tl::unexpected(loaded.error());
    if (loaded->map.key_frame_count() == 0) return fail(file + ": the map is empty");
    inputs.headers.push_back(loaded->header);
    if (const auto fits = storage::check_mergeable(inputs.headers.front(), loaded->header); !fits)
      return fail(file + ": it can't be merged with " + files.front() + ": " + fits.error().message);
    inputs.maps.push_back({loaded->map.state(), loaded->header.sensor, loaded->header.camera});
  }
  return inputs;
}

// Names submaps by the files they come from.
struct Names {
  const MergeArguments& arguments;
  const MergeReport& report;

  // The input that has a submap.
  size_t input_of(uint32_t submap) const {
    for (size_t i = 0; i < report.inputs.size(); ++i) {
      const auto& submaps = report.inputs[i].submaps;
      if (std::find(submaps.begin(), submaps.end(), submap) != submaps.end()) return i;
    }
    return 0;
  }
  // The submap's number within its file.
  size_t number_of(uint32_t submap) const {
    const auto& submaps = report.inputs[input_of(submap)].submaps;
    return static_cast<size_t>(std::find(submaps.begin(), submaps.end(), submap) - submaps.begin());
  }
  std::string name(uint32_t submap) const {
    const size_t input = input_of(submap);
    std::string text = arguments.files[input];
    if (report.inputs[input].submaps.size() > 1) text += " (map " + std::to_string(number_of(submap)) + ")";
    return text;
  }
  // The number of the map of the new file that a submap became a part of.
  size_t went_to(uint32_t submap) const {
    const auto& maps = report.join.maps;
    const auto at = std::find_if(maps.begin(), maps.end(), [&](const JoinedMap& map) {
      return std::binary_search(map.of.begin(), map.of.end(), submap);
    });
    return static_cast<size_t>(at - maps.begin());
  }
};

// The submaps of an input say little of one another: they were not joined when they were mapped.
bool of_two_inputs(const Names& names, const JoinedPair& pair) {
  return names.input_of(pair.older) != names.input_of(pair.younger);
}

nlohmann::json to_json(const Names& names, const JoinedPair& pair) {
  const LoopEvidence& e = pair.evidence;
  nlohmann::json json{
      {"maps",
       {names.arguments.files[names.input_of(pair.older)], names.arguments.files[names.input_of(pair.younger)]}},
      {"submaps", {names.number_of(pair.older), names.number_of(pair.younger)}},
      {"joined", pair.refusal == JoinRefusal::none},
      {"matches", e.matches},
      {"inliers", e.inliers},
      {"both_ways", e.both_ways},
      {"found_again", e.found_again},
      {"in_view", e.in_view},
      {"claims", pair.claims},
      {"contrary", pair.contrary},
      {"views_agree", pair.views_agree},
      {"views_disagree", pair.views_disagree},
      {"views_contradict", pair.views_contradict}};
  if (pair.refusal == JoinRefusal::none) {
    const Eigen::Vector3d& t = pair.S_older_younger.t();
    json["fused"] = pair.fused;
    json["scale"] = pair.S_older_younger.scale();
    json["translation"] = {t.x(), t.y(), t.z()};
    json["rotation_deg"] = so3_log(pair.S_older_younger.R()).norm() * 180 / std::numbers::pi;
  } else {
    json["reason"] = name(pair.refusal);
    if (pair.refusal == JoinRefusal::not_verified) json["refusal"] = name(pair.why);
  }
  return json;
}

nlohmann::json to_json(const Names& names, const Map& map) {
  const MergeReport& report = names.report;
  nlohmann::json json{{"out", names.arguments.out},         {"key_frames", map.key_frame_count()},
                      {"points", map.point_count()},        {"camera_of", names.arguments.files[report.camera_of]},
                      {"search_ms", report.join.search_ms}, {"join_ms", report.join.join_ms},
                      {"adjust_ms", report.join.adjust_ms}};
  for (size_t i = 0; i < report.inputs.size(); ++i) {
    const MergedInput& input = report.inputs[i];
    nlohmann::json in = nlohmann::json::array();
    for (const uint32_t submap : input.submaps) in.push_back(names.went_to(submap));
    json["inputs"].push_back({{"file", names.arguments.files[i]},
                              {"key_frames", input.key_frames},
                              {"points", input.points},
                              {"maps", std::move(in)}});
  }
  for (const JoinedMap& made : report.join.maps) {
    nlohmann::json of = nlohmann::json::array();
    for (const uint32_t submap : made.of) of.push_back(names.name(submap));
    json["maps"].push_back({{"of", std::move(of)},
                            {"key_frames", map.submap(made.id)->key_frames},
                            {"correction_m", made.correction},
                            {"adjusted_cost", {made.cost.before, made.cost.after}}});
  }
  json["pairs"] = nlohmann::json::array();
  for (const JoinedPair& pair : report.join.pairs) json["pairs"].push_back(to_json(names, pair));
  return json;
}

void print(const Names& names, const JoinedPair& pair) {
  const LoopEvidence& e = pair.evidence;
  const std::string both = names.name(pair.younger) + " and " + names.name(pair.older);
  if (pair.refusal == JoinRefusal::none) {
    std::printf("joined          %s: by %d views, the best of %d inliers and %d of %d points found again; %d fused",
                both.c_str(), pair.claims, e.inliers, e.found_again, e.in_view, pair.fused);
    if (pair.S_older_younger.scale() != 1) std::printf(", scale %.4g", pair.S_older_younger.scale());
    std::printf("\n");
    return;
  }
  std::printf("not joined      %s: %s", both.c_str(), name(pair.refusal));
  switch (pair.refusal) {
    case JoinRefusal::not_verified:
      std::printf(" (at best: %s; %d matches, %d inliers, %d of %d points found again)", name(pair.why), e.matches,
                  e.inliers, e.found_again, e.in_view);
      break;
    case JoinRefusal::unconfirmed:
      std::printf(" (%d)", pair.claims);
      break;
    case JoinRefusal::ambiguous:
      std::printf(" (%d views for one relation, %d for others)", pair.claims, pair.contrary);
      break;
    case JoinRefusal::contradicted:
      std::printf(" (%d of %d, %d of them next to nothing)", pair.views_disagree,
                  pair.views_agree + pair.views_disagree, pair.views_contradict);
      break;
    default:
      break;
  }
  std::printf("\n");
}

void print(const Names& names, const Map& map) {
  const MergeReport& report = names.report;
  for (size_t i = 0; i < report.inputs.size(); ++i) {
    const MergedInput& input = report.inputs[i];
    std::string to;
    for (const uint32_t submap : input.submaps) to += (to.empty() ? "" : ", ") + std::to_string(names.went_to(submap));
    std::printf("%-15s %zu key frames, %zu points, to map %s\n", names.arguments.files[i].c_str(), input.key_frames,
                input.points, to.c_str());
  }
  for (const JoinedPair& pair : report.join.pairs) {
    if (of_two_inputs(names, pair) || pair.refusal == JoinRefusal::none) print(names, pair);
  }
  for (size_t m = 0; m < report.join.maps.size(); ++m) {
    const JoinedMap& made = report.join.maps[m];
    std::printf("map %-11zu %zu key frames", m, map.submap(made.id)->key_frames);
    if (made.of.size() > 1) std::printf(", corrected by up to %.3g m", made.correction);
    std::printf("\n");
  }
  std::printf("%-15s %zu key frames, %zu points, %zu %s\n", names.arguments.out.c_str(), map.key_frame_count(),
              map.point_count(), report.join.maps.size(), report.join.maps.size() == 1 ? "map" : "maps, not joined");
}

int run_merge(const MergeArguments& a) {
  LoopOptions options;
  if (const auto set = set_loops(a.settings, options); !set) return fail_with(set.error());
  if (const auto right = check_files(a); !right) return fail_with(right.error());
  const auto vocabulary = open_vocabulary(a.vocabulary);
  if (!vocabulary) return fail_with(vocabulary.error());
  if (!*vocabulary) return fail_with("--vocabulary none: places can't be looked for without a vocabulary");
  std::optional<exchange::KeptImages> images;
  if (a.keep_images) {
    auto opened = exchange::KeptImages::open_to_write(exchange::image_folder(a.out));
    if (!opened) return fail_with(opened.error());
    images = std::move(*opened);
  }
  auto inputs = load(a.files);
  if (!inputs) return fail_with(inputs.error());
  log(LogLevel::info, std::to_string(a.files.size()) + " maps are loaded; places that they share are looked for");
  SharedMap merged;
  const auto report = merge_maps(std::move(inputs->maps), **vocabulary, options, merged);
  if (!report) return fail_with(report.error());
  const auto map = merged.read();
  const storage::MapHeader& of = inputs->headers[report->camera_of];
  storage::MapHeader header = storage::header_of(of.camera, of.sensor, {}, vocabulary->get());
  header.levels = of.levels;
  header.factor = of.factor;
  if (const auto saved = storage::save_map(a.out, map->state(), header); !saved) return fail_with(saved.error());
  if (images) {
    const auto kept = keep_merged_images(a.files, *report, *map, *images);
    if (!kept) return fail_with(kept.error());
    log(LogLevel::info, images->folder().string() + ": the images of " + std::to_string(*kept) + " of " +
                            std::to_string(map->key_frame_count()) + " key frames");
  }
  const Names names{a, *report};
  if (a.json) {
    print_json(to_json(names, *map));
  } else {
    print(names, *map);
  }
  return 0;
}

}  // namespace

void add_map_merge(CLI::App& map_command, int& exit_code) {
  auto a = std::make_shared<MergeArguments>();
  CLI::App* command = map_command.add_subcommand("merge", "Make one map of several, joined where they show the same");
  command
      ->add_option(
          "FILES", a->files,
          "saved maps; the first one's world is kept, or of cameras with and without depth the first one's with depth")
      ->required()
      ->expected(2, -1);
  command->add_option("--out", a->out, "file for the merged map")->required();
  command->add_option("--vocabulary", a->vocabulary, "vocabulary (default: the one that ships)");
  command->add_option("--set", a->settings, "one setting of loops, loop.NAME=VALUE; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--keep-images", a->keep_images,
                    "keep the images that were kept with the files in the folder OUT.images, for covis map export");
  command->add_flag("--json", a->json, "the report as JSON on stdout");
  command->footer(
      "Maps that share no place stay apart in the one file, and the report says why. The given maps are left as they "
      "are.\nExample:\n  covis map merge monday.m tuesday.m --out site.m");
  command->callback([a, &exit_code] { exit_code = run_merge(*a); });
}

}  // namespace covis::app
