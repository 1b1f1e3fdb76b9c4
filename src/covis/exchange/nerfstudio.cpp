// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/nerfstudio.h"

#include <nlohmann/json.hpp>

#include "covis/core/atomic_file.h"
#include "covis/exchange/point_cloud.h"

namespace covis::exchange {
namespace {

nlohmann::json rows_of(const Eigen::Matrix4d& m) {
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

// T_nw: the map's world in nerfstudio's.
Eigen::Matrix4d camera_to_world(const SE3& T_cw, const SE3& T_nw) {
  const SE3 T_nc = T_nw * T_cw.inverse();
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = T_nc.R() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  m.topRightCorner<3, 1>() = T_nc.t();
  return m;
}

nlohmann::json intrinsics(const SceneCamera& camera) {
  const Pinhole& c = camera.pinhole;
  return {{"w", camera.given.width},   {"h", camera.given.height}, {"fl_x", c.fx}, {"fl_y", c.fy},
          {"cx", c.cx + kPixelCentre}, {"cy", c.cy + kPixelCentre}};
}

// Intrinsics are those of all frames or, where there are several cameras, each frame's own: nerfstudio looks for them
// in frames only if none are above.
nlohmann::json transforms(const Scene& scene, const SE3& T_nw, const std::string& images, const std::string& cloud) {
  nlohmann::json frames = nlohmann::json::array();
  for (const SceneView& view : scene.views) {
    if (view.image.empty()) continue;  // a frame to train on is its image
    frames.push_back({{"file_path", images + "/" + view.image},
                      {"transform_matrix", rows_of(camera_to_world(view.T_cw, T_nw))},
                      {"timestamp", to_seconds(view.stamp)}});
    if (scene.cameras.size() > 1) frames.back().update(intrinsics(scene.cameras[view.camera]));
  }
  nlohmann::json all{{"camera_model", "PINHOLE"}, {"ply_file_path", cloud}, {"frames", std::move(frames)}};
  if (scene.cameras.size() == 1) all.update(intrinsics(scene.cameras.front()));
  return all;
}

}  // namespace

Result<void> write_nerfstudio(const std::filesystem::path& folder, const std::string& name, const Scene& scene,
                              const std::string& images, io::CloudUnit unit) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder can't be made: " + error.message());
  const Eigen::Matrix3d R = seen_from_above(scene);
  const SE3 T_nw(R, Eigen::Vector3d::Zero());
  if (auto written = io::write_ply(folder / (name + ".ply"), cloud_of(scene, R), unit); !written) return written;
  return write_atomically(
      folder / (name + ".json"),
      transforms(scene, T_nw, images, name + ".ply").dump(1, ' ', false, nlohmann::json::error_handler_t::replace) +
          "\n");
}

}  // namespace covis::exchange
