// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <thread>

#include "covis/core/random.h"
#include "covis/map/shared_map.h"

namespace covis {
namespace {

FeaturesPtr make_features(Random& random, int count, bool with_depth) {
  auto f = std::make_shared<Features>();
  f->pyramid = std::make_shared<ScalePyramid>(8, 1.2f);
  for (int i = 0; i < count; ++i) {
    f->x.push_back(static_cast<float>(random.uniform(0, 640)));
    f->y.push_back(static_cast<float>(random.uniform(0, 480)));
    f->angle.push_back(0);
    f->level.push_back(static_cast<uint8_t>(random.below(8)));
    f->depth.push_back(with_depth ? 2.0f : 0.0f);
    f->u_right.push_back(with_depth ? f->x.back() - 20 : -1.0f);
    Descriptor d;
    for (uint64_t& word : d.bits) word = random.next();
    f->descriptor.push_back(d);
  }
  f->grid.build({0, 0, 640, 480}, f->x, f->y);
  return f;
}

SE3 pose_at(double x) { return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-x, 0, 0)); }

struct Fixture {
  Random random{1};
  Map map;
  KeyFrameId frame(double x, bool with_depth = false, int features = 400) {
    return map.add_key_frame(static_cast<int64_t>(10 * x), 0, pose_at(x), make_features(random, features, with_depth));
  }
  // `count` new points seen by both, from feature `first` on.
  void share(KeyFrameId a, KeyFrameId b, int count, uint32_t first) {
    for (uint32_t k = 0; k < static_cast<uint32_t>(count); ++k) {
      const MapPointId p = map.add_point({0, 0, 5}, a, first + k);
      ASSERT_TRUE(p.valid());
      ASSERT_TRUE(map.add_observation(p, b, first + k));
    }
  }
};

TEST(SlotStore, StaleHandlesFindNothing) {
  SlotStore<MapPointId, int> store;
  const MapPointId a = store.insert(1), b = store.insert(2);
  EXPECT_TRUE(store.erase(a));
  EXPECT_FALSE(store.erase(a));
  EXPECT_EQ(store.find(a), nullptr);
  const MapPointId c = store.insert(3);
  EXPECT_EQ(c.slot, a.slot);
  EXPECT_NE(c, a);
  EXPECT_EQ(store.find(a), nullptr);
  EXPECT_EQ(store.at(b), 2);
  EXPECT_EQ(store.size(), 2u);
}

TEST(Map, CovisibilityQueries) {
  Fixture f;
  const KeyFrameId a = f.frame(0), b = f.frame(1), c = f.frame(2), d = f.frame(3);
  f.share(a, b, 20, 0);
  f.share(a, c, 30, 50);
  f.share(a, d, 5, 100);
  f.share(b, d, 120, 150);
  for (const KeyFrameId id : {b, c, d}) f.map.attach_to_tree(id);
  EXPECT_EQ(f.map.check(), "");
  EXPECT_EQ(f.map.weight(a, b), 20);
  EXPECT_EQ(f.map.weight(c, d), 0);
  auto n = f.map.neighbours(a);
  ASSERT_EQ(n.size(), 2u);  // d shares too few
  EXPECT_EQ(n[0].key_frame, c);
  EXPECT_EQ(n[1].key_frame, b);
  EXPECT_EQ(f.map.best_neighbours(a, 1).size(), 1u);
  EXPECT_EQ(f.map.neighbours_above(a, 25).size(), 1u);
  EXPECT_EQ(f.map.neighbours_above(a, 5).size(), 3u);
  EXPECT_EQ(f.map.tracked_points(a, 2), 55);
  EXPECT_EQ(f.map.tracked_points(a, 3), 0);
  EXPECT_EQ(f.map.at(d).parent, b);
  // The essential graph: three tree edges, of which b-d is heavy too, and a loop edge.
  f.map.add_loop_edge(c, d);
  EXPECT_EQ(f.map.essential_graph().size(), 4u);
  EXPECT_EQ(f.map.check(), "");
}

TEST(Map, TheBestNeighbourStaysThoughItSharesFew) {
  Fixture f;
  const KeyFrameId a = f.frame(0), b = f.frame(1), c = f.frame(2);
  f.share(a, b, 4, 0);
  f.share(a, c, 6, 20);
  const auto n = f.map.neighbours(a);
  ASSERT_EQ(n.size(), 1u);
  EXPECT_EQ(n[0].key_frame, c);
}

TEST(Map, ErasingAKeyFrameReattachesItsChildren) {
  Fixture f;
  const KeyFrameId root = f.frame(0), e = f.frame(1), x = f.frame(2), y = f.frame(3), z = f.frame(4);
  f.share(root, e, 50, 0);
  f.map.attach_to_tree(e);
  f.share(e, x, 60, 60);
  f.map.attach_to_tree(x);
  f.share(e, y, 60, 130);
  f.map.attach_to_tree(y);
  f.share(e, z, 60, 200);
  f.map.attach_to_tree(z);
  f.share(root, x, 20, 300);  // x belongs to the root then, …
  f.share(x, y, 30, 330);     // … y to x, and z, which shares nothing with any, to the erased one's parent
  EXPECT_EQ(f.map.at(z).parent, e);
  const SE3 T_xr = f.map.at(x).T_cw * f.map.at(root).T_cw.inverse(), T_er = f.map.at(e).T_cw * f.map.at(root).T_cw.inverse();
  EXPECT_FALSE(f.map.erase_key_frame(root));
  f.map.protect(e);
  EXPECT_FALSE(f.map.erase_key_frame(e));
  f.map.unprotect(e);
  std::weak_ptr<const Features> features = f.map.at(e).features;
  EXPECT_TRUE(f.map.erase_key_frame(e));
  EXPECT_FALSE(f.map.erase_key_frame(e));
  EXPECT_TRUE(features.expired());  // memory is really released
  EXPECT_EQ(f.map.check(), "");
  EXPECT_EQ(f.map.at(x).parent, root);
  EXPECT_EQ(f.map.at(y).parent, x);
  EXPECT_EQ(f.map.at(z).parent, root);
  // Poses of the erased can still be told, and follow their ancestors.
  EXPECT_TRUE(f.map.erase_key_frame(x));
  const auto resolved = f.map.resolve(x);
  ASSERT_TRUE(resolved);
  EXPECT_EQ(resolved->key_frame, root);
  EXPECT_LT((resolved->T_ar.t() - T_xr.t()).norm(), 1e-12);
  EXPECT_LT((f.map.resolve(e)->T_ar.t() - T_er.t()).norm(), 1e-12);
  EXPECT_FALSE(f.map.resolve(KeyFrameId{77, 0}));
  EXPECT_EQ(f.map.check(), "");
}

TEST(Map, ReplacementForwards) {
  Fixture f;
  const KeyFrameId a = f.frame(0), b = f.frame(1), c = f.frame(2);
  f.map.attach_to_tree(b);
  f.map.attach_to_tree(c);
  const MapPointId p = f.map.add_point({0, 0, 5}, a, 0), q = f.map.add_point({0, 0, 5}, b, 1), r = f.map.add_point({0, 0, 5}, c, 2);
  f.map.add_observation(p, b, 0);
  f.map.add_observation(q, c, 1);
  f.map.count_found(p, 9);
  EXPECT_TRUE(f.map.replace_point(p, q));  // b sees both: its feature 0 is let go
  EXPECT_FALSE(f.map.at(b).points[0].valid());
  EXPECT_EQ(f.map.at(a).points[0], q);
  EXPECT_EQ(f.map.at(q).found, 11u);
  EXPECT_EQ(f.map.at(q).observations.size(), 3u);
  f.map.add_observation(r, a, 5);
  EXPECT_TRUE(f.map.replace_point(q, r));
  EXPECT_EQ(f.map.forwarded(p), r);
  EXPECT_EQ(f.map.find(p), nullptr);
  EXPECT_FALSE(f.map.replace_point(r, r));
  f.map.erase_point(r);
  EXPECT_FALSE(f.map.forwarded(p).valid());
  EXPECT_EQ(f.map.check(), "");
}

TEST(Map, RefreshingAPoint) {
  Fixture f;
  const KeyFrameId a = f.frame(-1), b = f.frame(1), c = f.frame(0);
  const MapPointId p = f.map.add_point({0, 0, 4}, a, 3);
  f.map.add_observation(p, b, 4);
  f.map.add_observation(p, c, 5);
  f.map.refresh_point(p);
  const MapPoint& point = f.map.at(p);
  EXPECT_NEAR(point.normal_w.x(), 0, 1e-12);
  EXPECT_GT(point.normal_w.z(), 0.9);
  const Features& features = *f.map.at(a).features;
  EXPECT_NEAR(point.d_max, std::sqrt(17.0) * features.pyramid->scale[features.level[3]], 1e-4);
  EXPECT_NEAR(point.d_min, point.d_max / features.pyramid->scale[7], 1e-4);
  // Of three descriptors the one with the least median distance (to itself 0, so the lesser of the two others).
  const std::vector<Descriptor> d{features.descriptor[3], f.map.at(b).features->descriptor[4], f.map.at(c).features->descriptor[5]};
  int best = 257;
  Descriptor expected;
  for (size_t i = 0; i < 3; ++i) {
    const int median = std::min(hamming(d[i], d[(i + 1) % 3]), hamming(d[i], d[(i + 2) % 3]));
    if (median < best) {
      best = median;
      expected = d[i];
    }
  }
  EXPECT_EQ(point.descriptor, expected);
}

TEST(Map, RefusesWhatIsNotFinite) {
  Fixture f;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const KeyFrameId a = f.frame(0);
  EXPECT_FALSE(f.map.add_key_frame(0, 0, pose_at(nan), make_features(f.random, 3, false)).valid());
  EXPECT_FALSE(f.map.set_pose(a, pose_at(nan)));
  EXPECT_FALSE(f.map.add_point({nan, 0, 1}, a, 0).valid());
  const MapPointId p = f.map.add_point({0, 0, 1}, a, 0);
  EXPECT_FALSE(f.map.set_position(p, {0, nan, 1}));
  EXPECT_EQ(f.map.refused_non_finite(), 4u);
  EXPECT_EQ(f.map.check(), "");
}

TEST(Map, OneViewWithDepthKeepsAPoint) {
  Fixture f;
  const KeyFrameId a = f.frame(0, true), b = f.frame(1, false);
  f.map.attach_to_tree(b);
  const MapPointId p = f.map.add_point({0, 0, 2}, a, 0), q = f.map.add_point({0, 0, 2}, a, 1);
  f.map.add_observation(p, b, 0);
  f.map.add_observation(q, b, 1);
  EXPECT_TRUE(f.map.erase_observation(p, b));
  EXPECT_NE(f.map.find(p), nullptr);
  EXPECT_TRUE(f.map.erase_observation(q, a));
  EXPECT_EQ(f.map.find(q), nullptr);
  EXPECT_EQ(f.map.check(), "");
}

TEST(Map, PartsStandBesideEachOther) {
  Fixture f;
  const KeyFrameId a = f.frame(0, true), b = f.frame(1, true);
  f.share(a, b, 30, 0);
  f.map.attach_to_tree(b);
  const KeyFrameId c = f.map.begin_part(20, 0, pose_at(0), make_features(f.random, 400, true));
  const KeyFrameId d = f.map.add_key_frame(30, 0, pose_at(1), make_features(f.random, 400, true), f.map.at(c).part);
  f.map.attach_to_tree(d);  // it shares nothing: below the newest of its own part
  const MapPointId p = f.map.add_point({0, 0, 5}, a, 300), q = f.map.add_point({0, 0, 5}, c, 300);
  EXPECT_EQ(f.map.at(d).parent, c);
  EXPECT_TRUE(f.map.is_root(a) && f.map.is_root(c));
  EXPECT_EQ(f.map.root(), a);
  EXPECT_EQ(f.map.parts().size(), 2u);
  EXPECT_EQ(f.map.key_frames(f.map.at(c).part), (std::vector<KeyFrameId>{c, d}));
  EXPECT_EQ(f.map.check(), "");
  // No point is seen from both, no root is erased.
  EXPECT_FALSE(f.map.add_observation(p, c, 5));
  EXPECT_FALSE(f.map.replace_point(p, q));
  EXPECT_FALSE(f.map.erase_key_frame(c));
  EXPECT_EQ(f.map.check(), "");
  EXPECT_TRUE(f.map.erase_part(f.map.at(c).part));
  EXPECT_FALSE(f.map.erase_part(1));
  EXPECT_EQ(f.map.find(q), nullptr);
  EXPECT_EQ(f.map.key_frame_count(), 2u);
  EXPECT_EQ(f.map.check(), "");
  const KeyFrameId e = f.map.begin_part(40, 0, SE3(), make_features(f.random, 10, true));
  EXPECT_EQ(f.map.at(e).part, 2u) << "numbers are not used again";
}

// What a part looks like from within does not change when it is joined to another.
TEST(Map, JoiningMovesAPartAsAWhole) {
  Fixture f;
  const KeyFrameId a = f.frame(0, true), b = f.frame(1, true);
  f.map.attach_to_tree(b);
  const uint32_t part = f.map.at(f.map.begin_part(20, 0, pose_at(0), make_features(f.random, 400, true))).part;
  const auto add = [&](double x) {
    return f.map.add_key_frame(static_cast<int64_t>(x), 0, pose_at(x), make_features(f.random, 400, true), part);
  };
  const KeyFrameId root = f.map.key_frames(part).front(), c = add(1), d = add(2), gone = add(3);
  f.share(root, c, 40, 0);
  f.map.attach_to_tree(c);
  f.share(c, d, 40, 50);
  f.map.attach_to_tree(d);
  f.share(d, gone, 40, 100);
  f.map.attach_to_tree(gone);
  const MapPointId p = f.map.add_point({0.3, -0.2, 5}, d, 200);
  f.map.add_observation(p, root, 200);
  f.map.refresh_point(p);
  f.map.add_loop_edge(root, d);
  EXPECT_TRUE(f.map.erase_key_frame(gone));
  const Eigen::Vector3d seen = f.map.at(d).T_cw * f.map.at(p).position_w;
  const float d_max = f.map.at(p).d_max;
  const SE3 T_gone_d = f.map.resolve(gone)->T_ar;
  const uint64_t moves = f.map.moves();

  const Sim3 S(so3_exp({0.1, 0.7, -0.3}), {4, 5, 6}, 2.5);
  EXPECT_FALSE(f.map.join_parts(c, d, S)) << "of one part";
  EXPECT_FALSE(f.map.join_parts(d, b, Sim3(Eigen::Matrix3d::Identity(), {0, NAN, 0}, 1)));
  EXPECT_EQ(f.map.moves(), moves);
  EXPECT_TRUE(f.map.join_parts(d, b, S));
  EXPECT_GT(f.map.moves(), moves);
  EXPECT_EQ(f.map.check(), "");
  EXPECT_EQ(f.map.parts().size(), 1u);
  EXPECT_EQ(f.map.root(), a);
  for (const KeyFrameId& id : {root, c, d}) EXPECT_EQ(f.map.at(id).part, f.map.at(a).part);
  EXPECT_EQ(f.map.at(d).parent, b);
  EXPECT_EQ(f.map.at(c).parent, d) << "the tree hangs on the key frame that was tied";
  EXPECT_EQ(f.map.at(root).parent, c);
  const Eigen::Vector3d now = f.map.at(d).T_cw * f.map.at(p).position_w;
  EXPECT_LT((now - 2.5 * seen).norm(), 1e-9);
  EXPECT_NEAR(f.map.at(p).d_max, 2.5 * d_max, 1e-4);
  const MapPoint moved = f.map.at(p);
  f.map.refresh_point_geometry(p);
  EXPECT_LT((moved.normal_w - f.map.at(p).normal_w).norm(), 1e-9);
  EXPECT_NEAR(moved.d_min, f.map.at(p).d_min, 1e-4);
  // Poses told before, of erased key frames as well, come along in the new unit.
  const auto resolved = f.map.resolve(gone);
  ASSERT_TRUE(resolved);
  EXPECT_DOUBLE_EQ(resolved->scale, 2.5);
  EXPECT_LT((resolved->T_ar.t() - 2.5 * T_gone_d.t()).norm(), 1e-9);
}

// The same operations on Map and on a naive model; both must agree after each.
struct Model {
  std::map<KeyFrameId, std::map<uint32_t, MapPointId>> frames;
  std::map<MapPointId, std::map<KeyFrameId, uint32_t>> points;
  std::map<KeyFrameId, uint32_t> part;
  std::set<KeyFrameId> roots;

  uint32_t part_of(MapPointId p) { return part[points[p].begin()->first]; }
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
    ASSERT_EQ(map.at(k).part, model.part.at(k));
    ASSERT_EQ(map.is_root(k), model.roots.contains(k));
  }
  ASSERT_EQ(map.parts().size(), model.roots.size());
}

TEST(Map, RandomOperationsAgreeWithAModel) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    Map map;
    Model model;
    const bool depth = seed % 2;
    uint32_t parts_begun = 0;
    constexpr int kFeatures = 30;
    const auto any_frame = [&] { return std::next(model.frames.begin(), random.below(static_cast<uint32_t>(model.frames.size())))->first; };
    const auto any_point = [&] { return std::next(model.points.begin(), random.below(static_cast<uint32_t>(model.points.size())))->first; };
    for (int step = 0; step < 1500; ++step) {
      const uint32_t what = random.below(100);
      if (model.frames.size() < 3 || what < 5) {
        const bool begins = model.frames.empty() || random.below(5) == 0;
        const SE3 pose = pose_at(random.uniform(-5, 5));
        const FeaturesPtr features = make_features(random, kFeatures, depth);
        const uint32_t part = begins ? parts_begun++ : model.part[any_frame()];
        const KeyFrameId k =
            begins ? map.begin_part(step, step, pose, features) : map.add_key_frame(step, step, pose, features, part);
        map.attach_to_tree(k);
        model.frames[k];
        model.part[k] = part;
        if (begins) model.roots.insert(k);
      } else if (what < 35 || model.points.size() < 5) {
        const KeyFrameId k = any_frame();
        const uint32_t feature = random.below(kFeatures);
        const MapPointId p = map.add_point({random.uniform(-1, 1), 0, 5}, k, feature);
        ASSERT_EQ(p.valid(), !model.frames[k].contains(feature));
        if (p.valid()) {
          model.frames[k][feature] = p;
          model.points[p][k] = feature;
        }
      } else if (what < 75) {
        const KeyFrameId k = any_frame();
        const MapPointId p = any_point();
        const uint32_t feature = random.below(kFeatures);
        const bool possible =
            !model.frames[k].contains(feature) && !model.points[p].contains(k) && model.part[k] == model.part_of(p);
        ASSERT_EQ(map.add_observation(p, k, feature), possible);
        if (possible) {
          model.frames[k][feature] = p;
          model.points[p][k] = feature;
        }
      } else if (what < 82) {
        const MapPointId p = any_point();
        const KeyFrameId k = any_frame();
        const bool possible = model.points[p].contains(k);
        ASSERT_EQ(map.erase_observation(p, k), possible);
        if (possible) model.erase_observation(p, k, depth);
      } else if (what < 86) {
        const MapPointId p = any_point();
        ASSERT_TRUE(map.erase_point(p));
        model.erase_point(p);
      } else if (what < 93) {
        const MapPointId old = any_point(), by = any_point();
        const bool possible = old != by && model.part_of(old) == model.part_of(by);
        ASSERT_EQ(map.replace_point(old, by), possible);
        if (possible) {
          const auto observers = model.points[old];
          model.erase_point(old);
          for (const auto& [k, feature] : observers) {
            if (model.points[by].contains(k)) continue;
            model.points[by][k] = feature;
            model.frames[k][feature] = by;
          }
          ASSERT_EQ(map.forwarded(old), by);
        }
      } else if (what < 97) {
        const KeyFrameId k = any_frame();
        const bool possible = !model.roots.contains(k);
        ASSERT_EQ(map.erase_key_frame(k), possible);
        if (possible) {
          const auto features = model.frames[k];
          for (const auto& [feature, p] : features) model.erase_observation(p, k, depth);
          model.frames.erase(k);
          model.part.erase(k);
          ASSERT_TRUE(map.resolve(k));
        }
      } else if (what < 98) {
        const KeyFrameId a = any_frame(), b = any_frame();
        if (a != b && model.part[a] == model.part[b]) map.add_loop_edge(a, b);
      } else if (random.below(8) != 0) {
        const KeyFrameId child = any_frame(), parent = any_frame();
        const Sim3 S(so3_exp({random.uniform(-1, 1), 0, 1}), {1, random.uniform(-1, 1), 2}, random.uniform(0.5, 2));
        const uint32_t from = model.part[child], to = model.part[parent];
        ASSERT_EQ(map.join_parts(child, parent, S), from != to);
        if (from == to) continue;
        std::erase_if(model.roots, [&](KeyFrameId k) { return model.part[k] == from; });
        for (auto& [k, part] : model.part) {
          if (part == from) part = to;
        }
      } else {
        const uint32_t part = random.below(parts_begun);
        const bool there =
            std::any_of(model.part.begin(), model.part.end(), [&](const auto& k) { return k.second == part; });
        ASSERT_EQ(map.erase_part(part), there);
        std::erase_if(model.points, [&](const auto& p) { return model.part[p.second.begin()->first] == part; });
        std::erase_if(model.frames, [&](const auto& k) { return model.part[k.first] == part; });
        std::erase_if(model.roots, [&](KeyFrameId k) { return model.part[k] == part; });
        std::erase_if(model.part, [&](const auto& k) { return k.second == part; });
      }
      expect_equal(map, model);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(SharedMap, ReadersAndAWriterTakeTurns) {
  SharedMap shared;
  std::jthread writer([&] {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
      const auto map = shared.write();
      const KeyFrameId id = map->add_key_frame(i, i, SE3(), make_features(random, 5, false));
      if (id != map->root()) map->attach_to_tree(id);
    }
  });
  std::vector<std::jthread> readers;
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&] {
      size_t last = 0;
      for (int i = 0; i < 100; ++i) {
        const auto map = shared.read();
        EXPECT_GE(map->key_frame_count(), last);
        last = map->key_frame_count();
        EXPECT_EQ(map->check(), "");
      }
    });
  }
  readers.clear();
  writer.join();
  EXPECT_EQ(shared.read()->key_frame_count(), 200u);
}

}  // namespace
}  // namespace covis
