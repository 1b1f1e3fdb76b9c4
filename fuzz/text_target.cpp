// SPDX-License-Identifier: Apache-2.0
// Text files: cameras, settings, trajectories, models of COLMAP, cameras of other programs, lists of kept images.
#include <string>
#include <vector>

#include "covis/core/fields.h"
#include "covis/exchange/colmap_model.h"
#include "covis/exchange/kept_images.h"
#include "covis/io/camera_file.h"
#include "covis/io/camera_import.h"
#include "covis/io/config.h"
#include "covis/io/trajectory.h"
#include "scratch.h"
#include "target.h"

namespace covis::fuzz {
namespace {

void run_camera(std::string_view bytes) {
  const MemoryFile file(bytes);
  const auto loaded = io::load_camera(file.path());
  if (!loaded) return;
  const MemoryFile again(io::camera_text(*loaded));
  require(io::load_camera(again.path()).has_value(), "a camera that was read is read again as it is written");
}

std::vector<std::string> camera_seeds() {
  io::CameraFile camera;
  camera.camera = {640, 480, {500, 501, 320, 240, 50}, Distortion::brown_conrady, {0.1, -0.2, 0.001, 0, 0}};
  camera.baseline = 0.1;
  camera.fps = 30;
  camera.depth_scale = 5000;
  return {io::camera_text(camera), "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 32\ncy: 24\n"};
}

// A field of each type, as the real settings have them.
struct Settings {
  int features = 1000;
  double factor = 1.2;
  bool realtime = false;
  std::string name = "best";
  Fields fields() {
    return {{"orb.features", &features, "number of keypoints", 50, 30000},
            {"orb.scale_factor", &factor, "factor between levels", 1.01, 2},
            {"system.realtime", &realtime, "frames at their own times"},
            {.name = "system.name", .value = &name, .doc = "name", .former = "system.title"}};
  }
};

void run_settings(std::string_view bytes) {
  const MemoryFile file(bytes);
  Settings settings;
  const auto loaded = io::load_settings(file.path(), settings.fields());
  require(settings.features >= 50 && settings.features <= 30000, "a setting is in its range");
  require(settings.factor >= 1.01 && settings.factor <= 2, "a setting is in its range");
  if (!loaded) return;
  const MemoryFile again(io::dump_settings(settings.fields()));
  Settings read;
  require(io::load_settings(again.path(), read.fields()).has_value(), "settings are read again as they are written");
  require(read.features == settings.features && read.name == settings.name, "settings stay as they are");
}

std::vector<std::string> settings_seeds() {
  return {io::dump_settings(Settings().fields()), "orb: {features: 2000}\nsystem.realtime: true\n"};
}

void run_trajectory(std::string_view bytes) {
  const MemoryFile file(bytes);
  for (const io::TrajectoryFormat format : {io::TrajectoryFormat::automatic, io::TrajectoryFormat::tum,
                                            io::TrajectoryFormat::kitti, io::TrajectoryFormat::euroc}) {
    const auto read = io::read_trajectory(file.path(), format);
    if (!read) continue;
    for (const StampedPose& pose : *read) require(pose.T_wc.all_finite(), "poses are finite");
  }
}

std::vector<std::string> trajectory_seeds() {
  return {"# stamp tx ty tz qx qy qz qw\n1.5 0 0 0 0 0 0 1\n2.5 1 0 0 0 0.6 0 0.8\n", "1 0 0 0 0 1 0 0 0 0 1 0.5\n",
          "#timestamp\n1403636579763555584,4.6,-1.7,0.8,0.5,-0.1,-0.8,-0.1,0,0,0\n"};
}

// Both files of a model, with a line of "%%" between them; those of a binary one after a line "binary".
void run_colmap(std::string_view bytes) {
  constexpr std::string_view kBetween = "\n%%\n", kBinary = "binary\n";
  const bool binary = bytes.starts_with(kBinary);
  if (binary) bytes.remove_prefix(kBinary.size());
  const std::filesystem::path folder = scratch_folder() / "colmap";
  std::filesystem::create_directories(folder);
  const size_t at = std::min(bytes.find(kBetween), bytes.size());
  const std::string ending = binary ? ".bin" : ".txt";
  std::filesystem::remove(folder / "cameras.txt");
  write_file(folder / ("cameras" + ending), bytes.substr(0, at));
  write_file(folder / ("images" + ending), at == bytes.size() ? "" : bytes.substr(at + kBetween.size()));
  const auto read = exchange::read_colmap(folder);
  if (!read) return;
  require(read->images.size() >= 2, "a model has two images or more");
  for (const auto& image : read->images) require(image.T_cw.all_finite(), "poses are finite");
}

template <class... Numbers>
std::string bytes_of(const Numbers&... numbers) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return bytes;
}

std::vector<std::string> colmap_seeds() {
  const std::string images = "\n%%\n1 1 0 0 0 0 0 0 1 a.png\n10 10 7 11 12 -1\n2 1 0 0 0 1 0 0 1 b/c d.png\n\n";
  const auto image = [](uint32_t id, const std::string& name) {
    return bytes_of(id, 1., 0., 0., 0., 0.5, 0., 0., uint32_t{1}) + name + '\0' +
           bytes_of(uint64_t{2}, 10., 10., uint64_t{7}, 11., 12., ~uint64_t{0});
  };
  const std::string camera =
      bytes_of(uint64_t{1}, uint32_t{1}, int32_t{1}, uint64_t{640}, uint64_t{480}, 500., 500., 320., 240.);
  return {"1 PINHOLE 640 480 500 500 320 240" + images,
          "# c\n1 OPENCV_FISHEYE 640 480 300 300 320 240 0.1 0 0 0" + images,
          "binary\n" + camera + "\n%%\n" + bytes_of(uint64_t{2}) + image(1, "a.png") + image(2, "b/c d.png")};
}

void run_camera_import(std::string_view bytes) {
  const MemoryFile file(bytes);
  const auto imported = io::import_camera_yaml(file.path());
  if (!imported || !*imported) return;
  const MemoryFile again(io::camera_text((**imported).file));
  require(io::load_camera(again.path()).has_value(), "an imported camera is read again as it is written");
}

std::vector<std::string> camera_import_seeds() {
  return {
      "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]\n  distortion_model: radtan\n"
      "  intrinsics: [500.0, 501.0, 320.0, 240.0]\n  resolution: [640, 480]\ncam1:\n"
      "  T_cn_cnm1:\n  - [1, 0, 0, -0.1]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n"
      "  camera_model: pinhole\n  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]\n  distortion_model: radtan\n"
      "  intrinsics: [500.0, 501.0, 320.0, 240.0]\n  resolution: [640, 480]\n",
      "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, "
      "1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0, 0, 0]}\n",
      "%YAML:1.0\ncamera_id: left_cam\nT_BS:\n  cols: 4\n  rows: 4\n"
      "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [752, 480]\ncamera_model: pinhole\n"
      "intrinsics: [458, 457, 367, 248]\ndistortion_model: radial-tangential\n"
      "distortion_coefficients: [-0.28, 0.07, 0, 0]\n",
      "{\"width\": 640, \"height\": 480, \"intrinsic_matrix\": [500, 0, 0, 0, 500, 0, 320, 240, 1]}"};
}

// The list of a map's images, in a folder with two of them.
void run_kept_images(std::string_view bytes) {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path made = scratch_folder() / "kept";
    std::filesystem::create_directories(made);
    for (const char* name : {"000001.png", "000002.jpg"}) write_file(made / name, "an image");
    return made;
  }();
  write_file(folder / "images.txt", bytes);
  const auto kept = exchange::KeptImages::read(folder);
  if (!kept) return;
  for (const uint32_t serial : {1u, 2u, 3u}) {
    const std::filesystem::path found = kept->find(serial, 1'000'000'000);
    require(found.empty() || found.parent_path() == folder, "images lie in their folder");
  }
}

std::vector<std::string> kept_images_seeds() {
  return {"000001.png 1000000000\n000002.jpg 2000000000\n", "../000001.png 1000000000\n/000002.jpg 1000000000\n"};
}

}  // namespace

std::vector<Target> text_targets() {
  return {{"camera", run_camera, camera_seeds},
          {"settings", run_settings, settings_seeds},
          {"trajectory", run_trajectory, trajectory_seeds},
          {"colmap", run_colmap, colmap_seeds},
          {"camera_import", run_camera_import, camera_import_seeds},
          {"kept_images", run_kept_images, kept_images_seeds}};
}

}  // namespace covis::fuzz
