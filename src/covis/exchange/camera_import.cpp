// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/camera_import.h"

#include <algorithm>

#include "covis/exchange/colmap_model.h"
#include "covis/io/files.h"

namespace covis::exchange {
namespace {

// COLMAP's rows are "ID MODEL WIDTH HEIGHT …", where models are in capitals.
bool is_colmap_cameras(std::string_view text) {
  bool is = false;
  io::for_each_line(text, [&](std::string_view line, int) {
    const auto parts = io::split(line);
    is = parts.size() >= 4 && io::parse_double(parts[0]) && io::parse_double(parts[2]) &&
         std::all_of(parts[1].begin(), parts[1].end(), [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; });
    return false;
  });
  return is;
}

Result<io::ImportedCamera> import_colmap_camera(const std::filesystem::path& file) {
  const auto camera = read_colmap_camera(file);
  if (!camera) return tl::unexpected(camera.error());
  if (auto checked = io::check_camera_bounds(file, *camera); !checked) return tl::unexpected(checked.error());
  io::ImportedCamera imported{.format = "COLMAP camera", .file = {}, .pair = {}, .notes = {}};
  imported.file.camera = *camera;
  return imported;
}

}  // namespace

Result<io::ImportedCamera> import_camera(const std::filesystem::path& file) {
  if (file.filename() == "cameras.bin") return import_colmap_camera(file);
  const auto text = io::read_text(file);
  if (!text) return tl::unexpected(text.error());
  if (file.filename() == "cameras.txt" || is_colmap_cameras(*text)) return import_colmap_camera(file);
  auto imported = io::import_camera_yaml(file);
  if (!imported) return tl::unexpected(imported.error());
  if (*imported) return std::move(**imported);
  return fail(
      file.string() +
      ": it is no camera that can be read. Readable are: Kalibr's camera chain (cam0: …), COLMAP's cameras.txt or "
      "cameras.bin, "
      "Kimera's LeftCameraParams.yaml or EuRoC's sensor.yaml (T_BS: …), ROS' camera_info as YAML "
      "(camera_matrix: …), Open3D's camera_intrinsic.json (intrinsic_matrix)");
}

}  // namespace covis::exchange
