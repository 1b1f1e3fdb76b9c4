// SPDX-License-Identifier: Apache-2.0
// Random operations on a map and on a naive model of it: both must agree after each.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "covis/map/test_map.h"

namespace covis {
namespace {

struct Model {
  std::map<KeyFrameId, std::map<uint32_t, MapPointId>> frames;
  std::map<MapPointId, std::map<KeyFrameId, uint32_t>> points;
  std::map<KeyFrameId, uint32_t> submap;
  std::set<KeyFrameId> roots;

  uint32_t submap_of(MapPointId p) { return submap[points[p].begin()->first]; }
  void observe(MapPointId p, KeyFrameId k, uint32_t feature) {
    frames[k][feature] = p;
    points[p][k] = feature;
  }
  void erase_point(MapPointId p) {
    for (const auto& [frame, feature] : points[p]) frames[frame].erase(feature);
    points.erase(p);
  }
  void erase_observation(MapPointId p, KeyFrameId k, bool depth) {
    frames[k].erase(points[p][k]);
    points[p].erase(k);
    if (points[p].size() < 2 && !(points[p].size() == 1 && depth)) erase_point(p);
  }
};

void expect_equal(const Map& map, const Model& model) {
  ASSERT_EQ(map.check(), "");
  ASSERT_EQ(map.key_frame_count(), model.frames.size());
  ASSERT_EQ(map.point_count(), model.points.size());
  for (const auto& [p, observers] : model.points) {
    ASSERT_NE(map.find(p), nullptr);
    std::map<KeyFrameId, uint32_t> seen;
    for (const Observation& o : map.at(p).observations) seen[o.key_frame] = o.feature;
    ASSERT_EQ(seen, observers);
  }
  for (const auto& [k, features] : model.frames) {
    std::map<KeyFrameId, int> weights;
    for (const auto& [feature, p] : features) {
      for (const auto& [other, unused] : model.points.at(p)) weights[other] += other != k;
    }
    weights.erase(k);
    for (const auto& [other, weight] : weights) ASSERT_EQ(map.weight(k, other), weight);
    ASSERT_EQ(map.at(k).shared.size(), weights.size());
    ASSERT_EQ(map.at(k).submap, model.submap.at(k));
    ASSERT_EQ(map.is_root(k), model.roots.contains(k));
  }
  ASSERT_EQ(map.submaps().size(), model.roots.size());
}

// A map and its model, and an operation at a time on both. What the operation says must be what the model expects.
class Both {
 public:
  explicit Both(uint64_t seed) : random_(seed), depth_(seed % 2) {}

  void any_operation(int step) {
    const uint32_t what = random_.below(100);
    if (model_.frames.size() < 3 || what < 5) return add_key_frame(step);
    if (model_.points.size() < 5 || what < 35) return add_point();
    if (what < 75) return add_observation();
    if (what < 82) return erase_observation();
    if (what < 86) return erase_point();
    if (what < 93) return replace_point();
    if (what < 97) return erase_key_frame();
    if (what < 98) return add_loop_edge();
    if (random_.below(8) != 0) return join_submaps();
    erase_submap();
  }
  void expect_equal() const { covis::expect_equal(map_, model_); }

 private:
  static constexpr int kFeatures = 30;

  template <class Container>
  auto any(const Container& container) {
    return std::next(container.begin(), random_.below(static_cast<uint32_t>(container.size())))->first;
  }
  KeyFrameId any_frame() { return any(model_.frames); }
  MapPointId any_point() { return any(model_.points); }
  uint32_t any_feature() { return random_.below(kFeatures); }

  void add_key_frame(int step) {
    const bool begins = model_.frames.empty() || random_.below(5) == 0;
    const SE3 pose = pose_at(random_.uniform(-5, 5));
    const FeaturesPtr features = random_features(random_, kFeatures, depth_ ? 2 : 0);
    const uint32_t submap = begins ? parts_begun_++ : model_.submap[any_frame()];
    const KeyFrameId k =
        begins ? map_.begin_submap(step, step, pose, features) : map_.add_key_frame(step, step, pose, features, submap);
    map_.attach_to_tree(k);
    model_.frames[k];
    model_.submap[k] = submap;
    if (begins) model_.roots.insert(k);
  }
  void add_point() {
    const KeyFrameId k = any_frame();
    const uint32_t feature = any_feature();
    const MapPointId p = map_.add_point({random_.uniform(-1, 1), 0, 5}, k, feature);
    ASSERT_EQ(p.valid(), !model_.frames[k].contains(feature));
    if (p.valid()) model_.observe(p, k, feature);
  }
  void add_observation() {
    const KeyFrameId k = any_frame();
    const MapPointId p = any_point();
    const uint32_t feature = any_feature();
    const bool possible =
        !model_.frames[k].contains(feature) && !model_.points[p].contains(k) && model_.submap[k] == model_.submap_of(p);
    ASSERT_EQ(map_.add_observation(p, k, feature), possible);
    if (possible) model_.observe(p, k, feature);
  }
  void erase_observation() {
    const MapPointId p = any_point();
    const KeyFrameId k = any_frame();
    const bool possible = model_.points[p].contains(k);
    ASSERT_EQ(map_.erase_observation(p, k), possible);
    if (possible) model_.erase_observation(p, k, depth_);
  }
  void erase_point() {
    const MapPointId p = any_point();
    ASSERT_TRUE(map_.erase_point(p));
    model_.erase_point(p);
  }
  void replace_point() {
    const MapPointId old = any_point(), by = any_point();
    const bool possible = old != by && model_.submap_of(old) == model_.submap_of(by);
    ASSERT_EQ(map_.replace_point(old, by), possible);
    if (!possible) return;
    const auto observers = model_.points[old];
    model_.erase_point(old);
    for (const auto& [k, feature] : observers) {
      if (!model_.points[by].contains(k)) model_.observe(by, k, feature);
    }
    ASSERT_EQ(map_.forwarded(old), by);
  }
  void erase_key_frame() {
    const KeyFrameId k = any_frame();
    const bool possible = !model_.roots.contains(k);
    ASSERT_EQ(map_.erase_key_frame(k), possible);
    if (!possible) return;
    const auto features = model_.frames[k];
    for (const auto& [feature, p] : features) model_.erase_observation(p, k, depth_);
    model_.frames.erase(k);
    model_.submap.erase(k);
    ASSERT_TRUE(map_.resolve(k));
  }
  void add_loop_edge() {
    const KeyFrameId a = any_frame(), b = any_frame();
    if (a != b && model_.submap[a] == model_.submap[b]) map_.add_loop_edge(a, b);
  }
  void join_submaps() {
    const KeyFrameId child = any_frame(), parent = any_frame();
    const Sim3 S(so3_exp({random_.uniform(-1, 1), 0, 1}), {1, random_.uniform(-1, 1), 2}, random_.uniform(0.5, 2));
    const uint32_t from = model_.submap[child], to = model_.submap[parent];
    ASSERT_EQ(map_.join_submaps(child, parent, S), from != to);
    if (from == to) return;
    std::erase_if(model_.roots, [&](KeyFrameId k) { return model_.submap[k] == from; });
    for (auto& [k, submap] : model_.submap) {
      if (submap == from) submap = to;
    }
  }
  void erase_submap() {
    const uint32_t submap = random_.below(parts_begun_);
    const bool there =
        std::any_of(model_.submap.begin(), model_.submap.end(), [&](const auto& k) { return k.second == submap; });
    ASSERT_EQ(map_.erase_submap(submap), there);
    std::erase_if(model_.points, [&](const auto& p) { return model_.submap[p.second.begin()->first] == submap; });
    std::erase_if(model_.frames, [&](const auto& k) { return model_.submap[k.first] == submap; });
    std::erase_if(model_.roots, [&](KeyFrameId k) { return model_.submap[k] == submap; });
    std::erase_if(model_.submap, [&](const auto& k) { return k.second == submap; });
  }

  Random random_;
  Map map_;
  Model model_;
  const bool depth_;
  uint32_t parts_begun_ = 0;
};

TEST(Map, RandomOperationsAgreeWithAModel) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    Both both(seed);
    for (int step = 0; step < 1500; ++step) {
      both.any_operation(step);
      both.expect_equal();
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace covis
