// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap.h"

#include <Eigen/Geometry>
#include <cassert>
#include <cstdint>
#include <string>

#include "covis/core/atomic_file.h"
#include "covis/exchange/text.h"

namespace covis::exchange {
namespace {

std::string cameras_text(const Scene& scene) {
  Text text;
  text.line("# CAMERA_ID, MODEL, WIDTH, HEIGHT, fx, fy, cx, cy");
  for (size_t k = 0; k < scene.cameras.size(); ++k) {
    const auto& [given, refined, c] = scene.cameras[k];
    text.line(k + 1, "PINHOLE", given.width, given.height, c.fx, c.fy, c.cx + kPixelCentre, c.cy + kPixelCentre);
  }
  return text.take();
}

std::string images_text(const Scene& scene) {
  Text text;
  text.line("# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME");
  text.line("# POINTS2D[] as (X, Y, POINT3D_ID)");
  for (const SceneView& view : scene.views) {
    const Eigen::Quaterniond q = view.T_cw.q();
    const Eigen::Vector3d& t = view.T_cw.t();
    text.line(view.serial + 1, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), view.camera + 1,
              view.image.empty() ? image_name(view.serial) : view.image);
    for (const SceneView::Keypoint& keypoint : view.keypoints)
      text(keypoint.u + kPixelCentre, keypoint.v + kPixelCentre, keypoint.point + 1);
    text.end_line();
  }
  return text.take();
}

std::string points_text(const Scene& scene) {
  Text text;
  text.line("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)");
  for (uint32_t i = 0; i < scene.points.size(); ++i) {
    const ScenePoint& point = scene.points[i];
    assert(point.seen.size() >= 2);
    const Eigen::Vector3d& p = point.position;
    text(i + 1, p.x(), p.y(), p.z(), int{point.colour[0]}, int{point.colour[1]}, int{point.colour[2]}, point.error);
    for (const ScenePoint::Sight& sight : point.seen) text(scene.views[sight.view].serial + 1, sight.keypoint);
    text.end_line();
  }
  return text.take();
}

}  // namespace

Result<void> write_colmap(const std::filesystem::path& folder, const Scene& scene) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder can't be made: " + error.message());
  if (auto written = write_atomically(folder / "cameras.txt", cameras_text(scene)); !written) return written;
  if (auto written = write_atomically(folder / "images.txt", images_text(scene)); !written) return written;
  return write_atomically(folder / "points3D.txt", points_text(scene));
}

}  // namespace covis::exchange
