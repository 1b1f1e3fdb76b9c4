// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <unordered_map>

#include "covis/exchange/kept_images.h"
#include "covis/map/colours.h"

namespace covis::exchange {
namespace {

bool inside(const Scene& scene, double u, double v) {
  return u >= -0.5 && v >= -0.5 && u < scene.width - 0.5 && v < scene.height - 0.5;
}

// The points that the views see; they are numbered in the order in which they are met.
class Points {
 public:
  explicit Points(Scene& scene) : scene_(scene) {}
  // Nothing for a point that is not among them.
  std::optional<uint32_t> find(MapPointId id) const {
    const auto at = index_.find(id);
    return at == index_.end() ? std::nullopt : std::optional(at->second);
  }
  uint32_t index_of(const Map& map, MapPointId id) {
    const auto [at, added] = index_.emplace(id, static_cast<uint32_t>(scene_.points.size()));
    if (added) {
      const MapPoint& from = map.at(id);
      ScenePoint& point = scene_.points.emplace_back();
      point.position = from.position_w;
      point.normal = -from.normal_w.stableNormalized();
    }
    return at->second;
  }

 private:
  Scene& scene_;
  std::unordered_map<MapPointId, uint32_t> index_;
};

void add_view(const Map& map, const KeyFrame& from, Points& points, Scene& scene) {
  SceneView& view = scene.views.emplace_back();
  view.serial = from.serial;
  view.stamp = from.stamp;
  view.T_cw = from.T_cw;
  view.image = image_name(from.serial);
  for (size_t f = 0; f < from.points.size(); ++f) {
    const double u = from.features->x[f], v = from.features->y[f];
    if (from.points[f].valid() && inside(scene, u, v))
      view.keypoints.push_back({u, v, points.index_of(map, from.points[f])});
  }
}

void find_sights(Scene& scene) {
  for (uint32_t v = 0; v < scene.views.size(); ++v) {
    const SceneView& view = scene.views[v];
    for (uint32_t k = 0; k < view.keypoints.size(); ++k) {
      const SceneView::Keypoint& keypoint = view.keypoints[k];
      ScenePoint& point = scene.points[keypoint.point];
      const Eigen::Vector2d at = scene.camera.project(view.T_cw * point.position);
      point.error += (at - Eigen::Vector2d(keypoint.u, keypoint.v)).norm();
      point.seen.push_back({v, k});
    }
  }
  for (ScenePoint& point : scene.points) point.error /= static_cast<double>(point.seen.size());
}

// From all observers, those outside the undistorted image included.
void find_colours(const Map& map, const std::vector<KeyFrameId>& key_frames, const Points& points, Scene& scene) {
  MeanColours colours(scene.points.size());
  for (const KeyFrameId& id : key_frames) {
    const KeyFrame& from = map.at(id);
    for (size_t f = 0; from.colours && f < from.points.size(); ++f) {
      const auto index = from.points[f].valid() ? points.find(from.points[f]) : std::nullopt;
      if (index) colours.add(*index, (*from.colours)[f]);
    }
  }
  for (size_t i = 0; i < scene.points.size(); ++i) scene.points[i].colour = colours.mean(i);
}

}  // namespace

std::string image_name(uint32_t serial) { return image_stem(serial) + ".png"; }

std::vector<Scene> scenes_of(const Map& map, int width, int height) {
  std::vector<Scene> scenes;
  for (const Submap& submap : map.submaps()) {
    Scene& scene = scenes.emplace_back();
    scene.width = width;
    scene.height = height;
    scene.camera = map.camera();
    Points points(scene);
    const std::vector<KeyFrameId> key_frames = map.key_frames(submap.id);
    for (const KeyFrameId& id : key_frames) add_view(map, map.at(id), points, scene);
    find_colours(map, key_frames, points, scene);
    find_sights(scene);
  }
  std::stable_sort(scenes.begin(), scenes.end(),
                   [](const Scene& a, const Scene& b) { return a.views.size() > b.views.size(); });
  return scenes;
}

Scene centred(const Scene& scene) {
  Scene made = scene;
  Pinhole& to = made.camera;
  to.fy = to.fx;
  to.cx = (scene.width - 1) / 2.0;
  to.cy = (scene.height - 1) / 2.0;
  for (SceneView& view : made.views) {
    for (SceneView::Keypoint& keypoint : view.keypoints) {
      const Eigen::Vector2d at = to.project(scene.camera.unproject(keypoint.u, keypoint.v));
      keypoint.u = at.x();
      keypoint.v = at.y();
    }
  }
  return made;
}

Eigen::Vector3d upward(const Scene& scene) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const SceneView& view : scene.views) sum -= view.T_cw.R().row(1).transpose();  // y is down
  return sum.norm() > 1e-6 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d(0, -1, 0);
}

Eigen::Matrix3d seen_from_above(const Scene& scene) {
  const Eigen::Vector3d up = upward(scene);
  Eigen::Vector3d ahead = scene.views.empty() ? Eigen::Vector3d(0, 0, 1) : scene.views.front().T_cw.R().row(2);
  ahead -= ahead.dot(up) * up;
  if (ahead.norm() < 1e-6) ahead = up.unitOrthogonal();  // it looks straight up or down
  ahead.normalize();
  Eigen::Matrix3d to_above;
  to_above << ahead.cross(up).transpose(), ahead.transpose(), up.transpose();
  return to_above;
}

}  // namespace covis::exchange
