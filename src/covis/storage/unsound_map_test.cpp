// SPDX-License-Identifier: Apache-2.0
// Contents that a file may have but no sound map has: each case is reported, and no map is made of it.
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "covis/storage/test_maps.h"

namespace covis::storage {
namespace {

using testing::HasSubstr;

// A state made unsound, and what is said of it (nothing: any message will do).
struct Unsound {
  const char* why;
  std::function<void(MapState&)> change;
};

// Places in a sound state that the cases change.
struct Places {
  explicit Places(const MapState& good)
      : last(static_cast<uint32_t>(good.key_frames.size() - 1)),
        observation(index_of(good.key_frames[0].points, [](uint32_t p) { return p != MapState::kNone; })),
        child(index_of(good.key_frames, [&](const KeyFrameState& k) {
          return k.parent != MapState::kNone && std::any_of(k.points.begin(), k.points.end(), [&](uint32_t p) {
                   const auto& above = good.key_frames[k.parent].points;
                   return p != MapState::kNone && std::find(above.begin(), above.end(), p) != above.end();
                 });
        })) {}

  template <class List, class Is>
  static size_t index_of(const List& list, Is is) {
    return static_cast<size_t>(std::find_if(list.begin(), list.end(), is) - list.begin());
  }

  const uint32_t last;       // key frame
  const size_t observation;  // feature of the first key frame that observes a point
  const size_t child;        // key frame that observes a point of its parent's
};

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<Unsound> unsound_trees(const Places& at) {
  return {{"no root", [](MapState& s) { s.root = MapState::kNone; }},
          {"no root", [=](MapState& s) { s.root = at.last + 1; }},
          {"", [=](MapState& s) { s.root = at.last; }},
          {"serial", [](MapState& s) { s.next_serial = 1; }},
          {"serial", [](MapState& s) { s.key_frames[1].serial = s.key_frames[2].serial; }},
          {"parent", [=](MapState& s) { s.key_frames[1].parent = at.last + 1; }},
          // A key frame without a parent begins a submap, but what is seen from there is seen from no other.
          {"submap", [=](MapState& s) { s.key_frames[at.child].parent = MapState::kNone; }},
          {"its own parent", [=](MapState& s) { s.key_frames[at.last].parent = at.last; }},
          {"",
           [=](MapState& s) {
             s.key_frames[at.last].parent = at.last - 1;
             s.key_frames[at.last - 1].parent = at.last;
           }},
          {"loop edge", [=](MapState& s) { s.key_frames[1].loop_edges = {at.last + 1}; }},
          {"loop edge", [](MapState& s) { s.key_frames[1].loop_edges = {1}; }},
          {"loop edges", [](MapState& s) {
             s.key_frames[1].loop_edges = {3, 2};
           }}};
}

std::vector<Unsound> unsound_key_frames(const Places& at) {
  return {{"not finite",
           [](MapState& s) {
             s.key_frames[1].T_cw = SE3(s.key_frames[1].T_cw.R(), {kNan, 0, 0});
           }},
          {"rotation",
           [](MapState& s) {
             s.key_frames[1].T_cw = SE3(Eigen::Matrix3d::Zero(), {0, 0, 0});
           }},
          {"translation beyond 1e+12 m",
           [](MapState& s) {
             s.key_frames[1].T_cw = SE3(s.key_frames[1].T_cw.R(), {0, 1e300, 0});
           }},
          {"rotation",
           [](MapState& s) {
             s.key_frames[1].T_cw = SE3(1.01 * s.key_frames[1].T_cw.R(), {0, 0, 0});
           }},
          {"stamp", [](MapState& s) { s.key_frames[1].stamp = std::numeric_limits<int64_t>::max(); }},
          {"next serial", [](MapState& s) { s.next_serial = 0xffffffff; }},
          {"no features", [](MapState& s) { s.key_frames[1].features = nullptr; }},
          {"place for each feature", [](MapState& s) { s.key_frames[1].points.pop_back(); }},
          {"observes", [](MapState& s) { s.key_frames[1].points[0] = static_cast<uint32_t>(s.points.size()); }},
          {"", [=](MapState& s) { s.key_frames[0].points[at.observation] = MapState::kNone; }}};
}

// Changes the first feature of a key frame, the array of which is given.
template <class Value>
Unsound feature_with(const char* why, AlignedVector<Value> Features::*array, Value value) {
  return {why, [=](MapState& s) {
            const auto changed = std::make_shared<Features>(*s.key_frames[1].features);
            ((*changed).*array)[0] = value;
            s.key_frames[1].features = changed;
          }};
}

std::vector<Unsound> unsound_features(const Places&) {
  constexpr float kNanf = std::numeric_limits<float>::quiet_NaN();
  return {feature_with("outside any image", &Features::x, 1e30f),
          feature_with("not finite", &Features::angle, kNanf),
          feature_with("orientation is not from 0 to 2 pi", &Features::angle, 1e30f),
          feature_with("orientation is not from 0 to 2 pi", &Features::angle, -0.1f),
          feature_with("column in the right image", &Features::u_right, 1e30f),
          feature_with("depth is not from 1e-12 to 1e12 m", &Features::depth, 1e30f),
          feature_with("depth is not from 1e-12 to 1e12 m", &Features::depth, 1e-30f),
          feature_with("level", &Features::level, uint8_t{8})};
}

std::vector<Unsound> unsound_cameras(const Places&) {
  const auto with = [](double Pinhole::*figure, double value) {
    return Unsound{"no valid camera", [=](MapState& s) { s.camera.*figure = value; }};
  };
  return {with(&Pinhole::fx, 1e-300), with(&Pinhole::fy, 1e300), with(&Pinhole::fx, kNan),
          with(&Pinhole::cx, 1e30),   with(&Pinhole::cy, kNan),  with(&Pinhole::bf, 1e300)};
}

std::vector<Unsound> unsound_points(const Places& at) {
  return {{"not finite", [](MapState& s) { s.points[0].position_w.x() = kNan; }},
          {"not finite", [](MapState& s) { s.points[0].d_max = std::numeric_limits<float>::infinity(); }},
          {"position beyond 1e+12 m", [](MapState& s) { s.points[0].position_w.y() = -1e300; }},
          {"normal", [](MapState& s) { s.points[0].normal_w.x() = 1e30; }},
          {"visible", [](MapState& s) { s.points[0].visible = 0xffffffff; }},
          {"visible in no frame", [](MapState& s) { s.points[0].visible = 0; }},
          {"found", [](MapState& s) { s.points[0].found = 0xffffffff; }},
          {"range of distances", [](MapState& s) { s.points[0].d_min = -1; }},
          {"range of distances", [](MapState& s) { s.points[0].d_min = s.points[0].d_max + 1; }},
          {"reference", [=](MapState& s) { s.points[0].reference = at.last + 1; }},
          {"no observation", [](MapState& s) { s.points.emplace_back(s.points[0]); }}};
}

TEST(MapState, UnsoundOnesAreRefused) {
  const MapState good = random_map(9, 500).state();
  ASSERT_TRUE(Map::from_state(good));
  const Places at(good);
  ASSERT_LE(at.child, at.last);
  for (const auto& cases :
       {unsound_trees(at), unsound_key_frames(at), unsound_features(at), unsound_cameras(at), unsound_points(at)}) {
    for (size_t k = 0; k < cases.size(); ++k) {
      SCOPED_TRACE(std::to_string(k) + ": " + cases[k].why);
      MapState state = good;
      cases[k].change(state);
      const auto made = Map::from_state(state);
      EXPECT_FALSE(made);
      EXPECT_THAT(made ? "" : made.error().message, HasSubstr(cases[k].why));
    }
  }
}

}  // namespace
}  // namespace covis::storage
