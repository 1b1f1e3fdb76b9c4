// SPDX-License-Identifier: Apache-2.0
#include "apps/view/open_view.h"

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "covis/core/mapped_file.h"
#include "covis/slam/snapshot.h"
#include "covis/storage/map_file.h"

namespace covis::view {
namespace {

using nlohmann::json;

json info_of(const std::filesystem::path& file, const storage::MapHeader& header, const Map& map) {
  const Camera& camera = header.camera;
  return {{"title", file.filename().string()},
          {"mode", "map"},
          {"source", "a saved map"},
          {"states", json::array()},
          {"sensor", name(header.sensor)},
          {"camera",
           {{"fx", camera.pinhole.fx},
            {"fy", camera.pinhole.fy},
            {"cx", camera.pinhole.cx},
            {"cy", camera.pinhole.cy},
            {"width", camera.width},
            {"height", camera.height}}},
          {"summary", json::array({{"key frames", std::to_string(map.key_frame_count())},
                                   {"points", std::to_string(map.point_count())},
                                   {"submaps", std::to_string(map.submaps().size())}})}};
}

Result<ViewState> open_map(const std::filesystem::path& file) {
  auto saved = storage::load_map(file);
  if (!saved) return tl::unexpected(saved.error());
  ViewState state;
  state.info = info_of(file, saved->header, saved->map).dump(-1, ' ', false, json::error_handler_t::replace);
  SharedMap map;
  *map.write() = std::move(saved->map);
  const TrajectoryLog no_frames;
  state.map = std::make_shared<const MapScene>(scene_of(*SnapshotSource(map, no_frames).get()));
  return state;
}

Result<ViewState> open_result(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kSceneFile;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    return fail(folder.string() + ": it has no " + kSceneFile +
                ": give a folder that covis run wrote (--out), or a saved map (--save-map)");
  }
  const auto opened = MappedFile::open(file);
  if (!opened) return tl::unexpected(opened.error());
  const auto bytes = (*opened)->bytes();
  auto state = state_of_file({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!state) return fail(file.string() + ": " + state.error().message + "; run covis again to write it anew");
  return state;
}

}  // namespace

Result<ViewState> open_view(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return fail(path.string() + ": there is no such file; give a result folder of covis run, or a saved map");
  return std::filesystem::is_directory(path, error) ? open_result(path) : open_map(path);
}

}  // namespace covis::view
