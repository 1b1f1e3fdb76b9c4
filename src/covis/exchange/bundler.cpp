// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/bundler.h"

#include <cassert>

#include "covis/core/atomic_file.h"
#include "covis/exchange/text.h"

namespace covis::exchange {
namespace {

std::string bundle_text(const Scene& scene) {
  const Eigen::Vector3d turned(1, -1, -1);  // turns the camera's axes
  Text text;
  text.line("# Bundle file v0.3");
  text.line(scene.views.size(), scene.points.size());
  for (const SceneView& view : scene.views) {
    const Pinhole& c = scene.cameras[view.camera].pinhole;
    assert(c.fx == c.fy);
    text.line(c.fx, 0, 0);
    for (int row = 0; row < 3; ++row) {
      const Eigen::Vector3d r = turned(row) * view.T_cw.R().row(row).transpose();
      text.line(r.x(), r.y(), r.z());
    }
    const Eigen::Vector3d t = turned.cwiseProduct(view.T_cw.t());
    text.line(t.x(), t.y(), t.z());
  }
  for (const ScenePoint& point : scene.points) {
    assert(point.seen.size() >= 2);
    text.line(point.position.x(), point.position.y(), point.position.z());
    text.line(int{point.colour[0]}, int{point.colour[1]}, int{point.colour[2]});
    text(point.seen.size());
    for (const ScenePoint::Sight& sight : point.seen) {
      const SceneView& view = scene.views[sight.view];
      const SceneView::Keypoint& keypoint = view.keypoints[sight.keypoint];
      const Pinhole& c = scene.cameras[view.camera].pinhole;
      text(sight.view, sight.keypoint, keypoint.u - c.cx, c.cy - keypoint.v);
    }
    text.end_line();
  }
  return text.take();
}

std::string list_text(const Scene& scene, const std::string& images) {
  Text text;
  for (const SceneView& view : scene.views)
    text.line(images + "/" + (view.image.empty() ? image_name(view.serial) : view.image), 0,
              scene.cameras[view.camera].pinhole.fx);
  return text.take();
}

}  // namespace

Result<void> write_bundler(const std::filesystem::path& folder, const Scene& scene, const std::string& images) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder can't be made: " + error.message());
  if (auto written = write_atomically(folder / "bundle.out", bundle_text(scene)); !written) return written;
  return write_atomically(folder / "list.txt", list_text(scene, images));
}

}  // namespace covis::exchange
