// SPDX-License-Identifier: Apache-2.0
#include "map_import.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>

#include "common.h"
#include "covis/exchange/colmap_import.h"
#include "covis/map/map_state.h"
#include "covis/storage/compatibility.h"
#include "covis/storage/map_file.h"
#include "places.h"

namespace covis::app {
namespace {

struct ImportArguments {
  std::string model, images, out, vocabulary;
  int features = OrbOptions{}.features;
};

int run_import(const ImportArguments& a) {
  if (const auto fits = storage::check_save_target(a.out); !fits) return fail_with(fits.error());
  const auto model = exchange::read_colmap(a.model);
  if (!model) return fail_with(model.error());
  const auto vocabulary = open_vocabulary(a.vocabulary);
  if (!vocabulary) return fail_with(vocabulary.error());
  OrbOptions orb;
  orb.features = a.features;
  SharedMap map(model->camera.pinhole);
  if (const auto made = exchange::import_colmap(*model, a.images, orb, map); !made) return fail_with(made.error());
  const storage::MapHeader header = storage::header_of(model->camera, Sensor::monocular, orb, vocabulary->get());
  if (const auto saved = storage::save_map(a.out, map.read()->state(), header); !saved) return fail_with(saved.error());
  std::cout << a.out << ": " << map.read()->key_frame_count() << " key frames of " << model->images.size()
            << " images, " << map.read()->point_count() << " points\n";
  return 0;
}

}  // namespace

void add_map_import(CLI::App& map_command, int& exit_code) {
  auto a = std::make_shared<ImportArguments>();
  CLI::App* command = map_command.add_subcommand("import", "Make a map of a COLMAP model, to localise in");
  command->add_option("MODEL", a->model, "folder with cameras.bin and images.bin, or cameras.txt and images.txt")
      ->required();
  command->add_option("--images", a->images, "folder of the model's images")->required();
  command->add_option("--out", a->out, "file for the map")->required();
  command->add_option("--features", a->features, "keypoints per image")
      ->capture_default_str()
      ->transform(whole_number_from(50, 30000));
  command->add_option("--vocabulary", a->vocabulary, "as for covis run");
  command->callback([a, &exit_code] { exit_code = run_import(*a); });
}

}  // namespace covis::app
