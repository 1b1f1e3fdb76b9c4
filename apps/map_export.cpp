// SPDX-License-Identifier: Apache-2.0
#include "map_export.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common.h"
#include "covis/core/log.h"
#include "covis/core/sensor.h"
#include "covis/exchange/bundler.h"
#include "covis/exchange/colmap.h"
#include "covis/exchange/geojson.h"
#include "covis/exchange/kept_images.h"
#include "covis/exchange/nerfstudio.h"
#include "covis/exchange/patch_alignment.h"
#include "covis/exchange/point_adjustment.h"
#include "covis/exchange/point_cloud.h"
#include "covis/exchange/scene_images.h"
#include "covis/io/output_check.h"
#include "covis/io/outputs.h"
#include "covis/io/trajectory.h"
#include "covis/storage/map_file.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;
using exchange::Scene;

enum class Format { ply, colmap, nerfstudio, tum, kitti, geojson, bundler };
const std::map<std::string, Format> kFormats{
    {"ply", Format::ply},     {"colmap", Format::colmap},   {"nerfstudio", Format::nerfstudio}, {"tum", Format::tum},
    {"kitti", Format::kitti}, {"geojson", Format::geojson}, {"bundler", Format::bundler}};

struct ExportArguments {
  std::string file, to, out, images;
  std::vector<double> origin;
  double heading = 0;
  std::optional<double> scale;
};

// The name for the k-th submap: FILE, then FILE_map1 and so on, as trajectories are called.
fs::path of_submap(const fs::path& file, size_t k) {
  if (k == 0) return file;
  fs::path name = file.stem();
  name += "_map" + std::to_string(k);
  name += file.extension();
  return file.parent_path() / name;
}

// The names that the submaps' files get must be free for them.
Result<void> check_files(const ExportArguments& a, io::OutputKind kind, size_t submaps) {
  for (size_t k = 0; k < submaps; ++k) {
    if (auto fits = io::check_output(of_submap(a.out, k), kind, {a.file}); !fits) return fits;
  }
  return {};
}

constexpr Format kModels[] = {Format::colmap, Format::nerfstudio, Format::bundler};

io::OutputKind kind_of_model(Format format) {
  return format == Format::colmap       ? io::OutputKind::colmap
         : format == Format::nerfstudio ? io::OutputKind::nerfstudio
                                        : io::OutputKind::bundler;
}

// The files of the k-th submap's model in the folder of the export; the first is of kind_of_model().
std::vector<fs::path> model_files(Format format, size_t k) {
  if (format == Format::colmap) {
    const fs::path folder = fs::path("sparse") / std::to_string(k);
    return {folder / "cameras.txt", folder / "images.txt", folder / "points3D.txt"};
  }
  if (format == Format::nerfstudio) return {of_submap("transforms.json", k), of_submap("transforms.ply", k)};
  const fs::path folder = k == 0 ? fs::path() : of_submap("bundle", k);
  return {folder / "bundle.out", folder / "list.txt"};
}

// The folder of the images in that of the export: those for Bundler are resampled, and so not those of the others.
const char* images_of(Format format) { return format == Format::bundler ? "images_centred" : "images"; }

// Files in a folder are replaced if an earlier export made it, of whichever format.
Result<void> check_folder(Format wanted, const fs::path& out, size_t submaps) {
  std::error_code none;
  bool earlier = !fs::is_directory(out, none) || fs::is_empty(out, none);
  for (const Format format : kModels) {
    for (size_t k = 0; k < (format == wanted ? submaps : 1); ++k) {
      const fs::path file = out / model_files(format, k).front();
      if (!fs::is_regular_file(file, none)) continue;
      if (auto fits = io::check_output(file, kind_of_model(format)); !fits) return fits;
      earlier = true;
    }
  }
  if (earlier) return {};
  return fail(out.string() + ": the folder holds other things, and no earlier export; choose another, or a new one");
}

Result<void> check_target(Format format, const ExportArguments& a, size_t submaps) {
  switch (format) {
    case Format::ply:
      return check_files(a, io::OutputKind::point_cloud, submaps);
    case Format::tum:
      return check_files(a, io::OutputKind::trajectory, submaps);
    case Format::kitti: {
      auto fits = check_files(a, io::OutputKind::trajectory, submaps);
      for (size_t k = 0; k < submaps && fits; ++k)
        fits = io::check_output(io::times_file(of_submap(a.out, k)), io::OutputKind::times, {a.file});
      return fits;
    }
    case Format::geojson:
      return check_files(a, io::OutputKind::geojson, 1);
    case Format::colmap:
    case Format::nerfstudio:
    case Format::bundler:
      return check_folder(format, a.out, submaps);
  }
  return {};
}

// Models of higher numbers from an earlier export are removed, because they would be mistaken for this one's.
void remove_left_models(Format format, const fs::path& out, size_t submaps) {
  std::error_code error;
  for (size_t k = submaps;; ++k) {
    const std::vector<fs::path> files = model_files(format, k);
    const fs::path first = out / files.front();
    if (!fs::is_regular_file(first, error) || !io::check_output(first, kind_of_model(format))) return;
    for (const fs::path& file : files) fs::remove(out / file, error);
    if (first.parent_path() != out) fs::remove(first.parent_path(), error);  // stays unless it is empty
  }
}

// One file for each submap. One that an earlier map left is named, not removed: its name may be somebody's own.
Result<void> write_clouds(const std::vector<Scene>& scenes, const fs::path& file, io::CloudUnit unit) {
  for (size_t k = 0; k < scenes.size(); ++k) {
    if (auto written = io::write_ply(of_submap(file, k), exchange::cloud_of(scenes[k]), unit); !written) return written;
  }
  std::error_code none;
  const fs::path left = of_submap(file, scenes.size());
  if (fs::exists(left, none))
    log(LogLevel::warning, left.string() + ": it was there before, and is no part of this map");
  return {};
}

Result<void> write_poses(const std::vector<Scene>& scenes, const fs::path& file, io::TrajectoryFormat format) {
  std::vector<Trajectory> trajectories;
  for (const Scene& scene : scenes) {
    Trajectory& trajectory = trajectories.emplace_back();
    for (const exchange::SceneView& view : scene.views) trajectory.push_back({view.stamp, view.T_cw.inverse()});
  }
  return io::write_trajectories(file, trajectories, format);
}

// True where the folder holds a model of another format with the same images.
bool shares_images(Format format, const fs::path& out) {
  std::error_code none;
  return std::ranges::any_of(kModels, [&](Format other) {
    return other != format && std::string_view(images_of(other)) == images_of(format) &&
           fs::is_regular_file(out / model_files(other, 0).front(), none);
  });
}

// The images go to this folder, if there are any; returns how many there are. Error: those that were named are not
// there, or not of key frames; `shared`: they are others than those of the model that is there.
Result<size_t> write_images(const ExportArguments& a, const fs::path& folder, bool shared, std::vector<Scene>& scenes) {
  const fs::path kept = a.images.empty() ? exchange::image_folder(a.file) : fs::path(a.images);
  std::vector<uint32_t> serials;
  for (const Scene& scene : scenes) {
    for (const exchange::SceneView& view : scene.views) serials.push_back(view.serial);
  }
  const size_t views = serials.size();
  size_t images = 0;
  if (!a.images.empty() || fs::is_directory(kept)) {
    const auto read = exchange::KeptImages::read(kept);
    if (!read) return tl::unexpected(read.error());
    if (const auto named = read->check_names(serials); !named) return tl::unexpected(named.error());
    for (Scene& scene : scenes) {
      const auto written = exchange::write_images(kept, folder, scene, !shared);
      if (!written) return tl::unexpected(written.error());
      images += *written;
    }
  }
  if (images == views) return images;
  const std::string how = kept.string() + ": of " + std::to_string(views) + " key frames " + std::to_string(images) +
                          " have an image there; covis run --keep-images keeps them";
  if (images == 0 && kFormats.at(a.to) == Format::nerfstudio) return fail(how + ", and nerfstudio is nothing without");
  log(LogLevel::warning, how);
  return images;
}

// These formats hold a point by the pixels at which it is seen.
bool has_observations(Format format) { return format == Format::colmap || format == Format::bundler; }

// Brings keypoints, where a folder of images is given, and points to the export's pixels. Leaves out what does not make
// a track, and logs how much that is.
Result<void> make_tracks(const std::string& out, const fs::path& images, std::vector<Scene>& scenes) {
  for (size_t k = 0; k < scenes.size(); ++k) {
    const auto unlike = images.empty() ? Result<size_t>(0) : exchange::align_keypoints(scenes[k], images);
    if (!unlike) return tl::unexpected(unlike.error());
    exchange::adjust_points(scenes[k]);
    const exchange::LeftOut left_out = exchange::keep_tracks(scenes[k]);
    std::ostringstream text;
    text << out << ": left out are ";
    if (!images.empty()) text << *unlike << " observations whose image does not show their point as its finest does, ";
    text << left_out.observations << " observations more than " << exchange::kMaxObservationError << " pixels off and "
         << left_out.points << " points that fewer than two key frames then see; the mean reprojection error is "
         << std::fixed << std::setprecision(2) << exchange::mean_error(scenes[k]) << " pixels";
    if (scenes.size() > 1) text << " (map " << k << ")";
    log(LogLevel::info, text.str());
  }
  return {};
}

Result<void> fill_folder(Format format, const ExportArguments& a, io::CloudUnit unit, std::vector<Scene>& scenes) {
  if (format == Format::bundler) {
    for (Scene& scene : scenes) scene = exchange::centred(scene);
  }
  const fs::path out = a.out, folder_of_images = out / images_of(format);
  const auto images = write_images(a, folder_of_images, shares_images(format, out), scenes);
  if (!images) return tl::unexpected(images.error());
  if (has_observations(format)) {
    if (const auto made = make_tracks(a.out, *images > 0 ? folder_of_images : "", scenes); !made) return made;
  }
  for (size_t k = 0; k < scenes.size(); ++k) {
    Result<void> written;
    if (format == Format::colmap) {
      written = write_colmap(out / model_files(format, k).front().parent_path(), scenes[k]);
    } else if (format == Format::nerfstudio) {
      written = write_nerfstudio(out, of_submap("transforms", k), scenes[k], images_of(format), unit);
    } else {
      const fs::path folder = model_files(format, k).front().parent_path();
      written = write_bundler(out / folder, scenes[k], (k == 0 ? "" : "../") + std::string(images_of(format)));
    }
    if (!written) return written;
  }
  remove_left_models(format, out, scenes.size());
  return {};
}

// A folder that this export made goes again when the export fails: the half of a model would look like a whole one.
Result<void> write_folder(Format format, const ExportArguments& a, io::CloudUnit unit, std::vector<Scene>& scenes) {
  std::error_code error;
  const bool ours = fs::symlink_status(a.out, error).type() == fs::file_type::not_found;
  auto written = fill_folder(format, a, unit, scenes);
  if (!written && ours) fs::remove_all(a.out, error);
  return written;
}

Result<exchange::GeoReference> reference_of(const ExportArguments& a, io::CloudUnit unit) {
  if (a.origin.size() < 2)
    return fail("--origin LATITUDE LONGITUDE [ALTITUDE] is missing: a map does not know where on the earth it is");
  exchange::GeoReference reference{.latitude = a.origin[0], .longitude = a.origin[1]};
  if (!a.scale && unit == io::CloudUnit::of_map)
    return fail(
        "--scale METRES is missing: " + a.file +
        " is a map of one camera, which does not know how many metres a unit of it is (docs/exports.md says how "
        "to find that)");
  if (a.origin.size() > 2) reference.altitude = a.origin[2];
  reference.heading = a.heading;
  reference.scale = a.scale.value_or(1);
  if (!(std::abs(reference.latitude) <= 89.9) || !(std::abs(reference.longitude) <= 180) ||
      !(std::abs(reference.altitude) <= 1e6))
    return fail("--origin: degrees are wanted, the latitude from -89.9 to 89.9 and the longitude from -180 to 180");
  if (!std::isfinite(reference.heading)) return fail("--heading: degrees are wanted");
  if (!std::isfinite(reference.scale)) return fail("--scale: metres a unit of the map are wanted");
  return reference;
}

Result<void> write(Format format, const ExportArguments& a, io::CloudUnit unit, std::vector<Scene>& scenes) {
  switch (format) {
    case Format::ply:
      return write_clouds(scenes, a.out, unit);
    case Format::tum:
      return write_poses(scenes, a.out, io::TrajectoryFormat::tum);
    case Format::kitti:
      return write_poses(scenes, a.out, io::TrajectoryFormat::kitti);
    case Format::geojson: {
      const auto reference = reference_of(a, unit);
      if (!reference) return tl::unexpected(reference.error());
      if (scenes.size() > 1)
        log(LogLevel::warning, a.file + ": its maps are not joined; the path of the first alone is written");
      return exchange::write_geojson(a.out, scenes.front(), *reference);
    }
    case Format::colmap:
    case Format::nerfstudio:
    case Format::bundler:
      return write_folder(format, a, unit, scenes);
  }
  return {};
}

// An option that says nothing to this format.
std::string idle_option(const ExportArguments& a, Format format) {
  const bool folder = format == Format::colmap || format == Format::nerfstudio || format == Format::bundler;
  if (!folder && !a.images.empty()) return "--images";
  if (format == Format::geojson) return "";
  return !a.origin.empty() ? "--origin" : a.heading != 0 ? "--heading" : a.scale ? "--scale" : "";
}

int run_export(const ExportArguments& a) {
  const Format format = kFormats.at(a.to);
  if (const std::string idle = idle_option(a, format); !idle.empty())
    return fail_with(idle + ": it says nothing to the format " + a.to);
  const auto loaded = storage::load_map(a.file);
  if (!loaded) return fail_with(loaded.error());
  std::vector<Scene> scenes = exchange::scenes_of(loaded->map, loaded->header.camera);
  if (scenes.empty()) return fail_with(a.file + ": the map is empty, there is nothing to export");
  if (const auto fits = check_target(format, a, scenes.size()); !fits) return fail_with(fits.error());
  const io::CloudUnit unit = io::unit_of(loaded->header.sensor);
  if (const auto written = write(format, a, unit, scenes); !written) return fail_with(written.error());
  if (format == Format::geojson) scenes.resize(1);
  size_t views = 0, points = 0;
  for (const Scene& scene : scenes) {
    views += scene.views.size();
    points += scene.points.size();
  }
  const bool poses_alone = format == Format::tum || format == Format::kitti || format == Format::geojson;
  std::cout << a.out << ": " << views << " key frames"
            << (poses_alone ? "" : " and " + std::to_string(points) + " points") << " of " << scenes.size() << " map"
            << (scenes.size() > 1 ? "s" : "") << "\n";
  return 0;
}

}  // namespace

void add_map_export(CLI::App& map_command, int& exit_code) {
  auto a = std::make_shared<ExportArguments>();
  CLI::App* command = map_command.add_subcommand("export", "Write the map for other programs (docs/exports.md)");
  command->add_option("FILE", a->file, "a saved map")->required();
  command->add_option("--to", a->to, "ply, colmap, nerfstudio, tum, kitti, geojson or bundler")
      ->required()
      ->check(CLI::IsMember(keys(kFormats)));
  command->add_option("--out", a->out, "folder for colmap, nerfstudio and bundler; file for the others")->required();
  command->add_option(
      "--images", a->images,
      "folder of the key frames' images, by their ids (default: FILE.images, which covis run --keep-images makes)");
  command
      ->add_option("--origin", a->origin,
                   "geojson: latitude and longitude of the first key frame, degrees, and altitude")
      ->expected(2, 3);
  command->add_option("--heading", a->heading, "geojson: where it looks, degrees from north to east")
      ->check(CLI::Range(-360., 360.));
  command
      ->add_option("--scale", a->scale,
                   "geojson: metres a unit of the map; wanted for maps of one camera, which have no metres")
      ->check(CLI::Range(1e-6, 1e6));
  command->callback([a, &exit_code] { exit_code = run_export(*a); });
}

}  // namespace covis::app
