// SPDX-License-Identifier: Apache-2.0
#include "apps/view/map_scene.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_map>

namespace covis::view {
namespace {

uint16_t quarter_pixels(float pixel) {
  return static_cast<uint16_t>(std::lround(std::clamp(kPixelUnits * pixel, 0.0f, 65535.0f)));
}

CameraRow camera_row(const Camera& camera) {
  const Pinhole& p = camera.pinhole;
  return {static_cast<float>(p.fx),
          static_cast<float>(p.fy),
          static_cast<float>(p.cx),
          static_cast<float>(p.cy),
          static_cast<uint32_t>(camera.width),
          static_cast<uint32_t>(camera.height)};
}

void add_key_frames(const Snapshot& snapshot, MapScene& scene) {
  std::unordered_map<KeyFrameId, uint32_t> serial_of;
  for (const Snapshot::KeyFrame& from : snapshot.key_frames) serial_of.emplace(from.id, from.serial);
  for (const RefinedCamera& camera : snapshot.other_cameras) scene.cameras.push_back(camera_row(camera.given));
  scene.key_frames.reserve(snapshot.key_frames.size());
  for (const Snapshot::KeyFrame& from : snapshot.key_frames) {
    KeyFrameRow& row = scene.key_frames.emplace_back();
    row.id = from.serial;
    row.submap = from.submap;
    row.frame = static_cast<int32_t>(from.frame);
    if (const auto parent = serial_of.find(from.parent); from.parent.valid() && parent != serial_of.end())
      row.parent = parent->second;
    row.stamp = to_seconds(from.stamp);
    row.pose = row_of(from.T_wc);
    row.camera = from.camera;
  }
}

void set_colour(const Snapshot::Point& point, PointRow& row) {
  row.colour = point.colour;
  row.has_colour = point.colour != kNoColour;
}

void add_points(const Snapshot& snapshot, MapScene& scene) {
  scene.points.reserve(snapshot.points.size());
  for (const Snapshot::Point& from : snapshot.points) {
    PointRow& row = scene.points.emplace_back();
    row.id = from.id.slot;
    row.submap = from.submap;
    for (size_t k = 0; k < 3; ++k) row.position[k] = static_cast<float>(from.position_w[static_cast<Eigen::Index>(k)]);
    row.frame = -1;
    set_colour(from, row);
  }
}

// Key frames come in the order in which they were made, so the first that observes a point is the oldest.
void add_observations(const Snapshot& snapshot, MapScene& scene) {
  scene.observations.reserve(snapshot.observations.size());
  scene.first_observation.assign(snapshot.key_frames.size() + 1, 0);
  for (const MapSnapshot::Observation& from : snapshot.observations) {
    PointRow& point = scene.points[from.point];
    if (point.frame < 0) point.frame = scene.key_frames[from.key_frame].frame;
    scene.observations.push_back({point.id, quarter_pixels(from.u), quarter_pixels(from.v)});
    ++scene.first_observation[from.key_frame + 1];
  }
  for (size_t k = 1; k < scene.first_observation.size(); ++k)
    scene.first_observation[k] += scene.first_observation[k - 1];
}

void add_edges(const Snapshot& snapshot, MapScene& scene) {
  scene.edges.reserve(snapshot.edges.size());
  for (const MapSnapshot::Edge& from : snapshot.edges) {
    const auto shared = static_cast<uint16_t>(std::clamp(from.shared, 0, 65535));
    scene.edges.push_back({scene.key_frames[from.a].id, scene.key_frames[from.b].id, shared, from.loop});
  }
  std::sort(scene.edges.begin(), scene.edges.end(),
            [](const EdgeRow& x, const EdgeRow& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
}

}  // namespace

PoseRow row_of(const SE3& T_wc) {
  const Eigen::Quaterniond q = T_wc.q();
  PoseRow row;
  for (size_t k = 0; k < 3; ++k) row.t[k] = static_cast<float>(T_wc.t()[static_cast<Eigen::Index>(k)]);
  row.q = {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()), static_cast<float>(q.w())};
  return row;
}

MapScene scene_of(const Snapshot& snapshot) {
  MapScene scene;
  add_key_frames(snapshot, scene);
  add_points(snapshot, scene);
  add_observations(snapshot, scene);
  add_edges(snapshot, scene);
  scene.path.reserve(snapshot.trajectory.size());
  for (const PoseOfFrame& from : snapshot.trajectory)
    scene.path.push_back({static_cast<int32_t>(from.frame), from.submap, row_of(from.T_wc)});
  return scene;
}

const KeyFrameRow* MapScene::key_frame(uint32_t id) const {
  const auto found = std::lower_bound(key_frames.begin(), key_frames.end(), id,
                                      [](const KeyFrameRow& row, uint32_t wanted) { return row.id < wanted; });
  return found != key_frames.end() && found->id == id ? &*found : nullptr;
}

std::vector<ObservationRow> observations_of_key_frame(const MapScene& scene, uint32_t id) {
  const KeyFrameRow* row = scene.key_frame(id);
  if (!row) return {};
  const auto k = static_cast<size_t>(row - scene.key_frames.data());
  return {scene.observations.begin() + scene.first_observation[k],
          scene.observations.begin() + scene.first_observation[k + 1]};
}

std::vector<ObservationRow> observations_of_point(const MapScene& scene, uint32_t id) {
  std::vector<ObservationRow> found;
  for (size_t k = 0; k < scene.key_frames.size(); ++k) {
    for (uint32_t i = scene.first_observation[k]; i < scene.first_observation[k + 1]; ++i) {
      const ObservationRow& o = scene.observations[i];
      if (o.other == id) found.push_back({scene.key_frames[k].id, o.u, o.v});
    }
  }
  return found;
}

}  // namespace covis::view
