// SPDX-License-Identifier: Apache-2.0
// For tests: a scene of bare points, and what a camera sees of it, without rendering a pixel. Features are made of the
// points' projections with known descriptors, levels and depths, so that maps with a known truth are made in
// milliseconds. Serves the tests of mapping, loops and tracking.
//
//   PointScene scene = PointScene::wall();                   // 600 points in front of a camera that moves sideways
//   const PointScene::View view = scene.view(scene.T_cw(3)); // features, and the scene's point behind each
//   SceneMap world(scene, Sensor::rgbd);                     // a map to put key frames into
//   world.add_key_frames(8);                                 // at their true poses, all points associated
#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "covis/core/sensor.h"
#include "covis/features/test_features.h"
#include "covis/features/test_patches.h"
#include "covis/map/map_requests.h"
#include "covis/map/shared_map.h"

namespace covis {

struct PointScene {
  struct Point {
    Eigen::Vector3d position_w;
    Descriptor descriptor;
    double reach = 8;                 // metres: the distance at which it is seen at level 0 (MapPoint::d_max)
    std::optional<uint32_t> twin_of;  // the index of a point that looks the same
  };
  // The view of a camera, without occlusion.
  struct View {
    FeaturesPtr features;
    std::vector<size_t> point;  // for each feature the index of its point in the scene
  };

  std::vector<Point> points;
  std::vector<SE3> T_wc;  // the camera's path
  Pinhole camera{500, 500, 320, 240, 50};
  ImageBounds bounds{0, 0, 640, 480};
  double noise = 0;       // pixels, standard deviation of each coordinate of a keypoint
  int flipped_bits = 0;   // bits of each descriptor, at random, in each view
  bool patches = false;   // views have patches, of a texture for each point
  double max_depth = 20;  // metres: points beyond have no depth in stereo and RGB-D views

  const SE3& T_wc_of(size_t i) const { return T_wc[i % T_wc.size()]; }
  SE3 T_cw(size_t i) const { return T_wc_of(i).inverse(); }

  void add_point(const Eigen::Vector3d& position_w, double reach, Random& random) {
    points.push_back({position_w, random_descriptor(random), reach, {}});
  }

  // Points 4 to 8 metres ahead of a camera that moves sideways along x, 0.2 metres a step.
  static PointScene wall(int count = 600, size_t steps = 20, uint64_t seed = 1) {
    PointScene scene;
    Random random(seed);
    const double end = 0.2 * static_cast<double>(steps);
    for (int p = 0; p < count; ++p)
      scene.add_point({random.uniform(-3, 3 + end), random.uniform(-2, 2), random.uniform(4, 8)}, 12, random);
    for (size_t i = 0; i < steps; ++i)
      scene.T_wc.emplace_back(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.2 * static_cast<double>(i), 0, 0));
    return scene;
  }

  // Points on a ring of 5 to 7 metres' radius about the y axis, seen by a camera that looks outward from a circle of 2
  // metres and is back where it began after `steps` views.
  static PointScene ring(int count = 2400, size_t steps = 48, uint64_t seed = 1) {
    PointScene scene;
    Random random(seed);
    for (int p = 0; p < count; ++p) {
      const double angle = random.uniform(0, 2 * std::numbers::pi), radius = random.uniform(5, 7);
      scene.add_point({radius * std::sin(angle), random.uniform(-1.5, 1.5), radius * std::cos(angle)}, 9, random);
    }
    for (size_t i = 0; i < steps; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(steps);
      scene.T_wc.emplace_back(so3_exp({0, angle, 0}), Eigen::Vector3d(2 * std::sin(angle), 0, 2 * std::cos(angle)));
    }
    return scene;
  }

  // A ring whose second half looks the same as its first, point by point.
  static PointScene twin_halves(int count = 2400, size_t steps = 48, uint64_t seed = 1) {
    PointScene scene = ring(count, steps, seed);
    std::erase_if(scene.points, [](const Point& p) { return p.position_w.x() < 0; });
    const auto half = static_cast<uint32_t>(scene.points.size());
    for (uint32_t p = 0; p < half; ++p) {
      Point twin = scene.points[p];
      twin.position_w = so3_exp({0, std::numbers::pi, 0}) * twin.position_w;
      twin.twin_of = p;
      scene.points.push_back(twin);
    }
    return scene;
  }

  // Every point that projects into the image from a true pose. `seed` tells the noise of views apart.
  View view(const SE3& T_cw, Sensor sensor = Sensor::rgbd, uint64_t seed = 0) const {
    Random random(hash_seed(0, 1, seed));
    Features f = no_features();
    if (patches) start_patches(f);
    View seen;
    for (size_t p = 0; p < points.size(); ++p) {
      const Eigen::Vector3d p_c = T_cw * points[p].position_w;
      if (p_c.z() < 0.1) continue;
      const Eigen::Vector2d truth = camera.project(p_c);
      Eigen::Vector2d pixel = truth;
      if (noise > 0) pixel += noise * Eigen::Vector2d(random.normal(), random.normal());
      if (!bounds.contains(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()))) continue;
      Descriptor descriptor = points[p].descriptor;
      for (int b = 0; b < flipped_bits; ++b) {
        const uint32_t bit = random.below(256);
        descriptor.bits[bit / 64] ^= uint64_t{1} << (bit % 64);
      }
      const int level = f.pyramid->predict_level(static_cast<float>(points[p].reach), static_cast<float>(p_c.norm()));
      const bool has_depth = sensor != Sensor::monocular && p_c.z() <= max_depth;
      add(f,
          {.x = pixel.x(), .y = pixel.y(), .level = level, .descriptor = descriptor, .depth = has_depth ? p_c.z() : 0},
          camera.bf);
      if (patches)
        f.patches->at.push_back(test_patch(pixel, truth, f.pyramid->scale[static_cast<size_t>(level)], TestTexture(p)));
      seen.point.push_back(p);
    }
    finish(f, bounds);
    seen.features = std::make_shared<const Features>(std::move(f));
    return seen;
  }

  // Words that a vocabulary would make of a view, had it one word for each point of the scene.
  std::shared_ptr<const Words> words(const View& view) const {
    std::map<uint32_t, float> weight;
    for (const size_t p : view.point)
      weight[points[p].twin_of.value_or(static_cast<uint32_t>(p))] += 1.0f / static_cast<float>(view.point.size());
    Words words;
    for (const auto& [word, w] : weight) words.words.push_back({word, w});
    return std::make_shared<const Words>(std::move(words));
  }
};

// The request for view `i` of the path as the first of a submap, with the points it was matched to; other features with
// depth make new ones.
inline KeyFrameRequest request_of(const PointScene& scene, size_t i, const PointScene::View& view,
                                  std::vector<MapPointId> matched) {
  KeyFrameRequest r;
  r.frame = r.stamp = static_cast<int64_t>(i);
  r.features = view.features;
  r.pose.T_cr = scene.T_cw(i);
  r.points = std::move(matched);
  for (uint32_t f = 0; f < view.point.size(); ++f) {
    if (!r.points[f].valid() && view.features->has_depth(static_cast<int>(f))) r.new_points.push_back(f);
  }
  return r;
}

// A map of a scene, and which of its points is which of the scene's.
struct SceneMap {
  const PointScene& scene;
  Sensor sensor;
  SharedMap shared;
  std::vector<KeyFrameId> frames;       // as they were added
  std::vector<PointScene::View> views;  // the view of each
  std::vector<MapPointId> handles;      // for each point of the scene the map's point, or an invalid handle
  size_t memory = ~size_t{0};           // key frames after which a point that was not seen again is taken for a new one

  explicit SceneMap(const PointScene& of, Sensor by = Sensor::rgbd)
      : scene(of), sensor(by), shared(of.camera), handles(of.points.size()), seen_(of.points.size()) {}

  // A view from a true pose as a key frame that the map takes to be at `T_cw`. Observes the scene's points the map has,
  // and adds the others at the places where this view, by its pose in the map, puts them.
  KeyFrameId add(const SE3& T_cw_true, const SE3& T_cw) {
    const size_t k = frames.size();
    views.push_back(scene.view(T_cw_true, sensor, k));
    const auto map = shared.write();
    const auto frame = static_cast<int64_t>(k);
    const KeyFrameId id = submap_ ? map->add_key_frame(frame, frame, T_cw, views.back().features, *submap_)
                                  : map->begin_submap(frame, frame, T_cw, views.back().features);
    submap_ = map->at(id).submap;
    const SE3 T_map_world = T_cw.inverse() * T_cw_true;
    for (uint32_t f = 0; f < views.back().point.size(); ++f) {
      const size_t p = views.back().point[f];
      handles[p] = map->forwarded(handles[p]);
      if (handles[p].valid() && k - seen_[p] <= memory) {
        map->add_observation(handles[p], id, f);
      } else {
        handles[p] = map->add_point(T_map_world * scene.points[p].position_w, id, f);
      }
      map->refresh_point(handles[p]);
      seen_[p] = k;
    }
    map->set_words(id, scene.words(views.back()));
    map->attach_to_tree(id);
    frames.push_back(id);
    return id;
  }
  KeyFrameId add(const SE3& T_cw_true) { return add(T_cw_true, T_cw_true); }
  // Key frames at every `step`-th pose of the scene's path, from `first` on.
  void add_key_frames(size_t count, size_t first = 0, size_t step = 1) {
    for (size_t i = 0; i < count; ++i) add(scene.T_cw(first + i * step));
  }

  // Forgets which of the map's points are which: points seen from now on are new ones, as after coming back
  // unrecognised.
  void forget_points() { handles.assign(scene.points.size(), {}); }
  // The next key frame begins a submap of its own, with points of its own.
  void begin_submap() {
    submap_.reset();
    forget_points();
  }

  // The request that makes view `i` of the path a key frame, relative to one of the map, with every point matched that
  // the map has; features with depth and without a point make new ones.
  KeyFrameRequest request(size_t i, KeyFrameId reference) const {
    const PointScene::View view = scene.view(scene.T_cw(i), sensor, i);
    const auto map = shared.read();
    std::vector<MapPointId> matched;
    for (const size_t p : view.point) matched.push_back(map->find(handles[p]) ? handles[p] : MapPointId{});
    KeyFrameRequest r = request_of(scene, i, view, std::move(matched));
    if (reference.valid()) r.pose = RelativePose::of(*map, scene.T_cw(i), reference);
    return r;
  }

 private:
  std::optional<uint32_t> submap_;  // that key frames are added to
  std::vector<size_t> seen_;        // for each point of the scene the key frame that saw it last
};

// For maps that others make of a scene, whose key frames are views of its path (KeyFrame::frame is the index): for each
// feature of a view the map's point that `from` observes there, if any. Every `keep`-th alone.
inline std::vector<MapPointId> points_matched(const Map& map, const PointScene& scene, Sensor sensor, KeyFrameId from,
                                              const PointScene::View& view, int keep = 1) {
  const KeyFrame& key_frame = map.at(from);
  const auto i = static_cast<size_t>(key_frame.frame);
  const PointScene::View then = scene.view(scene.T_cw(i), sensor, i);
  std::vector<MapPointId> handle(scene.points.size());
  int n = 0;
  for (size_t f = 0; f < then.point.size(); ++f) {
    if (key_frame.points[f].valid() && n++ % keep == 0) handle[then.point[f]] = key_frame.points[f];
  }
  std::vector<MapPointId> matched;
  for (const size_t p : view.point) matched.push_back(handle[p]);
  return matched;
}

// The request for view `i` of the path: beside a key frame, with the points it observes, or as the first of a submap,
// with a new point for each feature with depth.
inline KeyFrameRequest scene_request(const PointScene& scene, const SharedMap& shared, Sensor sensor, size_t i,
                                     KeyFrameId from = {}, int keep = 1) {
  const PointScene::View view = scene.view(scene.T_cw(i), sensor, i);
  if (!from.valid()) return request_of(scene, i, view, std::vector<MapPointId>(view.point.size()));
  const auto map = shared.read();
  KeyFrameRequest r = request_of(scene, i, view, points_matched(*map, scene, sensor, from, view, keep));
  r.pose = RelativePose::of(*map, scene.T_cw(i), from);
  r.new_points.clear();  // mapping is to make them
  return r;
}

}  // namespace covis
