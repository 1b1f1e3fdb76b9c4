// SPDX-License-Identifier: Apache-2.0
// Maps for the tests of saving: made by random operations, and compared field by field.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "covis/core/random.h"
#include "covis/features/test_features.h"
#include "covis/storage/map_file.h"

namespace covis::storage {

inline MapHeader test_header() {
  MapHeader header;
  header.camera = {640, 480, {500, 501, 320.5, 240.25, 40}, Distortion::brown_conrady, {0.1, -0.2, 0.001, 0.002, 0.03}};
  header.sensor = Sensor::rgbd;
  header.levels = 8;
  header.factor = 1.2f;
  header.vocabulary = "0123456789abcdef";
  return header;
}

// Camera of the key frames, which differs from the given one.
inline Pinhole refined_camera() { return {490, 490.98, 320.5, 240.25, 40}; }

inline FeaturesPtr random_features(Random& random, int count) {
  auto f = std::make_shared<Features>(no_features());
  const bool lens = random.below(2) == 0;  // true: a camera with distortion
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0, 640), y = random.uniform(0, 480), angle = random.uniform(0, 6.28);
    const int level = static_cast<int>(random.below(8));
    const double depth = random.below(3) == 0 ? 0 : random.uniform(1, 9);
    add(*f, {x, y, level, random_descriptor(random), angle, depth});
    if (!lens) continue;
    f->raw_x.push_back(f->x.back() + static_cast<float>(random.uniform(-3, 3)));
    f->raw_y.push_back(f->y.back() + static_cast<float>(random.uniform(-3, 3)));
  }
  finish(*f, {-1.5f, 0, 641, 480});
  return f;
}

inline SE3 random_pose(Random& random) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi(i) = random.uniform(-1, 1);
  return SE3::exp(xi);
}

// Makes a map like that of a long run: slots are reused, handles are stale, serials have gaps.
inline Map random_map(uint64_t seed, int steps, int features = 30) {
  Random random(seed);
  Map map;
  map.set_camera(refined_camera());
  const auto any = [&](const auto& list) { return list[random.below(static_cast<uint32_t>(list.size()))]; };
  for (int step = 0; step < steps; ++step) {
    const uint32_t what = random.below(100);
    if (map.key_frame_count() < 3 || what < 7) {
      const Timestamp stamp = Timestamp{1403715273262142976} + Timestamp{50000000} * step;
      const SE3 pose = random_pose(random);
      const FeaturesPtr made = random_features(random, features);
      const bool begins = map.submaps().empty() || random.below(6) == 0;
      const KeyFrameId added = begins ? map.begin_submap(step, stamp, pose, made)
                                      : map.add_key_frame(step, stamp, pose, made, any(map.submaps()).id);
      map.attach_to_tree(added);
      if (seed % 2 == 0 && step % 3 > 0) {  // maps of odd seeds are of grey images
        const auto tone = static_cast<uint8_t>(step);
        std::vector<Colour> colours(static_cast<size_t>(features), Colour{tone, 7, 9});
        map.set_colours(added, std::make_shared<const std::vector<Colour>>(std::move(colours)));
      }
    } else if (map.point_count() < 5 || what < 45) {
      map.add_point({random.uniform(-1, 1), random.uniform(-1, 1), 5}, any(map.key_frames()),
                    random.below(static_cast<uint32_t>(features)));
    } else if (what < 80) {
      const MapPointId p = any(map.points());
      map.add_observation(p, any(map.key_frames()), random.below(static_cast<uint32_t>(features)));
      map.count_visible(p, random.below(4));
      map.count_found(p, random.below(3));
      if (random.below(2) == 0) map.refresh_point(p);
    } else if (what < 85) {
      map.erase_point(any(map.points()));
    } else if (what < 90) {
      map.replace_point(any(map.points()), any(map.points()));
    } else if (what < 96) {
      map.erase_key_frame(any(map.key_frames()));
    } else {
      const KeyFrameId a = any(map.key_frames()), b = any(map.key_frames());
      if (a != b && map.at(a).submap == map.at(b).submap) map.add_loop_edge(a, b);
      if (random.below(4) == 0) map.join_submaps(a, b, Sim3(random_pose(random), 1.5));
    }
  }
  return map;
}

inline void expect_equal(const Features& a, const Features& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.raw_x, b.raw_x);
  EXPECT_EQ(a.raw_y, b.raw_y);
  EXPECT_EQ(a.angle, b.angle);
  EXPECT_EQ(a.u_right, b.u_right);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.level, b.level);
  EXPECT_EQ(a.descriptor, b.descriptor);
  EXPECT_EQ(a.grid.filled, b.grid.filled);
  EXPECT_EQ(a.grid.before, b.grid.before);
  EXPECT_EQ(a.grid.offsets, b.grid.offsets);
  EXPECT_EQ(a.grid.indices, b.grid.indices);
  EXPECT_EQ(a.grid.inv_cell_width, b.grid.inv_cell_width);
  EXPECT_EQ(a.grid.bounds.min_x, b.grid.bounds.min_x);
  EXPECT_EQ(a.grid.bounds.max_y, b.grid.bounds.max_y);
  EXPECT_EQ(a.pyramid->scale, b.pyramid->scale);
  EXPECT_EQ(a.pyramid->inv_sigma2, b.pyramid->inv_sigma2);
}

// Compares all but the handles: the k-th key frame by serial and the k-th point by slot correspond.
inline void expect_equal(const Map& a, const Map& b) {
  const auto a_frames = a.key_frames(), b_frames = b.key_frames();
  const auto a_points = a.points(), b_points = b.points();
  ASSERT_EQ(a_frames.size(), b_frames.size());
  ASSERT_EQ(a_points.size(), b_points.size());
  EXPECT_EQ(a.next_serial(), b.next_serial());
  EXPECT_EQ(a.camera(), b.camera());
  const auto frame = [&](KeyFrameId id) {  // handle in `a` to handle in `b`
    const auto at = std::find(a_frames.begin(), a_frames.end(), id);
    return at == a_frames.end() ? KeyFrameId{} : b_frames[static_cast<size_t>(at - a_frames.begin())];
  };
  ASSERT_EQ(a.submaps().size(), b.submaps().size());
  for (size_t p = 0; p < a.submaps().size(); ++p) {
    EXPECT_EQ(frame(a.submaps()[p].root), b.submaps()[p].root);
    EXPECT_EQ(a.submaps()[p].key_frames, b.submaps()[p].key_frames);
  }
  for (size_t i = 0; i < a_frames.size(); ++i) {
    const KeyFrame &k = a.at(a_frames[i]), &l = b.at(b_frames[i]);
    EXPECT_EQ(k.serial, l.serial);
    EXPECT_EQ(k.frame, l.frame);
    EXPECT_EQ(k.stamp, l.stamp);
    EXPECT_EQ(k.T_cw.R(), l.T_cw.R());
    EXPECT_EQ(k.T_cw.t(), l.T_cw.t());
    expect_equal(*k.features, *l.features);
    ASSERT_EQ(k.colours == nullptr, l.colours == nullptr);
    if (k.colours) {
      EXPECT_EQ(*k.colours, *l.colours);
    }
    EXPECT_EQ(frame(k.parent), l.parent);
    const auto has = [](const auto& list, KeyFrameId id) { return std::binary_search(list.begin(), list.end(), id); };
    EXPECT_EQ(k.children.size(), l.children.size());
    for (const KeyFrameId& id : k.children) EXPECT_TRUE(has(l.children, frame(id)));
    EXPECT_EQ(k.loop_edges.size(), l.loop_edges.size());
    for (const KeyFrameId& id : k.loop_edges) EXPECT_TRUE(has(l.loop_edges, frame(id)));
    EXPECT_EQ(k.shared.size(), l.shared.size());
    for (const Neighbour& n : k.shared) EXPECT_EQ(n.weight, b.weight(b_frames[i], frame(n.key_frame)));
  }
  for (size_t i = 0; i < a_points.size(); ++i) {
    const MapPoint &p = a.at(a_points[i]), &q = b.at(b_points[i]);
    EXPECT_EQ(p.position_w, q.position_w);
    EXPECT_EQ(p.normal_w, q.normal_w);
    EXPECT_EQ(p.descriptor, q.descriptor);
    EXPECT_EQ(p.d_min, q.d_min);
    EXPECT_EQ(p.d_max, q.d_max);
    EXPECT_EQ(frame(p.reference), q.reference);
    EXPECT_EQ(p.visible, q.visible);
    EXPECT_EQ(p.found, q.found);
    ASSERT_EQ(p.observations.size(), q.observations.size());
    for (const Observation& o : p.observations) EXPECT_EQ(b.at(frame(o.key_frame)).points[o.feature], b_points[i]);
  }
}

}  // namespace covis::storage
