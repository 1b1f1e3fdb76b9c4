// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>
#include <unordered_map>

#include "covis/exchange/kept_images.h"
#include "covis/geometry/measurement.h"
#include "covis/map/colours.h"
#include "covis/matching/point_geometry.h"

namespace covis::exchange {
namespace {

// The points that the views see; they are numbered in the order in which they are met.
class Points {
 public:
  explicit Points(Scene& scene) : scene_(scene) {}
  // Empty for a point that is not among them.
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

// The index of the camera that made a key frame; it is added where it is new.
uint32_t camera_of(const KeyFrame& key_frame, Scene& scene) {
  if (!key_frame.features->made_by) return 0;
  const RefinedCamera& camera = *key_frame.features->made_by;
  const auto at = std::find_if(scene.cameras.begin() + 1, scene.cameras.end(), [&](const SceneCamera& c) {
    return c.given == camera.given && c.refined == camera.pinhole;
  });
  const auto index = static_cast<uint32_t>(at - scene.cameras.begin());
  if (at == scene.cameras.end()) scene.cameras.push_back({camera.given, camera.pinhole, camera.pinhole});
  return index;
}

// By how much the turn between the rows of a rolling shutter was taken out of a keypoint of the map's camera, which
// need not have one any more. Other cameras of a map are not known to have one.
Eigen::Vector2d rolled(const SceneCamera& camera, const Features& features, size_t i) {
  constexpr double kRounding = 0.01;  // pixels
  auto shown = camera.given.undistort(Eigen::Vector2f(features.image_x()[i], features.image_y()[i]).cast<double>());
  if (shown) shown = camera.refined.straightened(*shown);
  if (!shown) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d by = *shown - Eigen::Vector2f(features.x[i], features.y[i]).cast<double>();
  return by.norm() > kRounding ? by : Eigen::Vector2d::Zero();
}

void add_view(const Map& map, const KeyFrame& from, Points& points, Scene& scene) {
  SceneView& view = scene.views.emplace_back();
  view.serial = from.serial;
  view.camera = camera_of(from, scene);
  view.stamp = from.stamp;
  view.T_cw = from.T_cw;
  view.image = image_name(from.serial);
  const SceneCamera& camera = scene.cameras[view.camera];
  for (size_t f = 0; f < from.points.size(); ++f) {
    if (!from.points[f].valid()) continue;
    Eigen::Vector2d at(from.features->x[f], from.features->y[f]);
    if (view.camera > 0) at = camera.pinhole.project(map.camera().unproject(at.x(), at.y()));
    if (!camera.sees(at.x(), at.y())) continue;
    const double scale = from.features->pyramid->scale[from.features->level[f]];  // in the map's camera
    view.keypoints.push_back({.u = at.x(),
                              .v = at.y(),
                              .rolled = view.camera > 0 ? Eigen::Vector2d::Zero() : rolled(camera, *from.features, f),
                              .point = points.index_of(map, from.points[f]),
                              .scale = scale * camera.pinhole.fx / map.camera().fx,
                              .disparity = disparity_of(*from.features, f, map.camera())});
  }
}

// The distance of a keypoint from its point's projection, pixels; infinite where that is behind the camera.
double error_of(const Scene& scene, const SceneView& view, const SceneView::Keypoint& keypoint) {
  const Eigen::Vector3d p_c = view.T_cw * scene.points[keypoint.point].position;
  if (!(p_c.z() > kMinDepth)) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d at = scene.cameras[view.camera].pinhole.project(p_c);
  return (at - Eigen::Vector2d(keypoint.u, keypoint.v)).norm();
}

// A point's colour is the mean of all its observers, those outside the undistorted image included.
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

bool SceneCamera::sees(double u, double v) const {
  return u >= -0.5 && v >= -0.5 && u < given.width - 0.5 && v < given.height - 0.5;
}

std::vector<Scene> scenes_of(const Map& map, const Camera& given) {
  std::vector<Scene> scenes;
  for (const Submap& submap : map.submaps()) {
    Scene& scene = scenes.emplace_back();
    scene.cameras.push_back({given, map.camera(), map.camera()});
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

void find_sights(Scene& scene) {
  for (ScenePoint& point : scene.points) {
    point.error = 0;
    point.seen.clear();
  }
  for (uint32_t v = 0; v < scene.views.size(); ++v) {
    const SceneView& view = scene.views[v];
    for (uint32_t k = 0; k < view.keypoints.size(); ++k) {
      ScenePoint& point = scene.points[view.keypoints[k].point];
      point.error += error_of(scene, view, view.keypoints[k]);
      point.seen.push_back({v, k});
    }
  }
  for (ScenePoint& point : scene.points) point.error /= std::max(1.0, static_cast<double>(point.seen.size()));
}

LeftOut keep_tracks(Scene& scene) {
  LeftOut left_out;
  std::vector<uint32_t> sights(scene.points.size());
  for (SceneView& view : scene.views) {
    left_out.observations += std::erase_if(view.keypoints, [&](const SceneView::Keypoint& keypoint) {
      return !(error_of(scene, view, keypoint) <= kMaxObservationError);
    });
    for (const SceneView::Keypoint& keypoint : view.keypoints) ++sights[keypoint.point];
  }
  std::vector<uint32_t> number(scene.points.size());
  std::vector<ScenePoint> points;
  for (size_t i = 0; i < scene.points.size(); ++i) {
    number[i] = static_cast<uint32_t>(points.size());
    if (sights[i] < 2) continue;
    points.push_back(std::move(scene.points[i]));
  }
  left_out.points = scene.points.size() - points.size();
  scene.points = std::move(points);
  for (SceneView& view : scene.views) {
    std::erase_if(view.keypoints, [&](const SceneView::Keypoint& keypoint) { return sights[keypoint.point] < 2; });
    for (SceneView::Keypoint& keypoint : view.keypoints) keypoint.point = number[keypoint.point];
  }
  find_sights(scene);
  return left_out;
}

double mean_error(const Scene& scene) {
  double sum = 0;
  for (const ScenePoint& point : scene.points) sum += point.error;
  return scene.points.empty() ? 0 : sum / static_cast<double>(scene.points.size());
}

Scene centred(const Scene& scene) {
  Scene made = scene;
  for (SceneCamera& camera : made.cameras) {
    Pinhole& to = camera.pinhole;
    to.fy = to.fx;
    to.cx = (camera.given.width - 1) / 2.0;
    to.cy = (camera.given.height - 1) / 2.0;
  }
  for (SceneView& view : made.views) {
    const Pinhole &from = scene.cameras[view.camera].pinhole, &to = made.cameras[view.camera].pinhole;
    for (SceneView::Keypoint& keypoint : view.keypoints) {
      const Eigen::Vector2d shown = keypoint.in_image();
      const Eigen::Vector2d at = to.project(from.unproject(keypoint.u, keypoint.v));
      keypoint.rolled = to.project(from.unproject(shown.x(), shown.y())) - at;
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
