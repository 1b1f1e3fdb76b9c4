// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_state.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "covis/core/stamp_bounds.h"

namespace covis {
namespace {

constexpr uint32_t kNone = MapState::kNone;
constexpr float kMaxPixel = 1e6f;  // far beyond any image; the grid's arithmetic is safe below it
// Far beyond any world, and their squares are far from what a float can hold.
constexpr double kMaxLength = 1e12, kMinDepth = 1e-12;  // metres
constexpr float kMaxAngle = 6.2832f;                    // 2 pi, rounded up
constexpr uint32_t kMaxSerial = 1u << 31;               // it does not overflow for as long as a run may go on

std::string frame_name(size_t i) { return "key frame " + std::to_string(i); }
std::string point_name(size_t i) { return "point " + std::to_string(i); }

bool are_pixels(const AlignedVector<float>& values) {
  // A NaN compares false with everything.
  return std::all_of(values.begin(), values.end(), [](float v) { return std::abs(v) <= kMaxPixel; });
}

bool are_finite(const AlignedVector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

bool are_angles(const AlignedVector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return v >= 0 && v <= kMaxAngle; });
}

// A feature without depth has 0 or less.
bool are_depths(const AlignedVector<float>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](float v) { return v <= 0 || (v >= kMinDepth && v <= kMaxLength); });
}

// A feature without a right image's column has a negative one.
bool are_columns(const AlignedVector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return v <= kMaxPixel; });
}

bool is_within(const Eigen::Vector3d& p, double bound) { return p.cwiseAbs().maxCoeff() <= bound; }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

bool valid_bounds(const ImageBounds& b) {
  for (const float v : {b.min_x, b.min_y, b.max_x, b.max_y}) {
    if (!(std::abs(v) <= kMaxPixel)) return false;
  }
  return b.max_x - b.min_x >= 1 && b.max_y - b.min_y >= 1;
}

std::string problem_of(const MapState& state, size_t index) {
  const KeyFrameState& k = state.key_frames[index];
  const auto frames = static_cast<uint32_t>(state.key_frames.size());
  if (!k.features) return "has no features";
  if (std::string problem = covis::problem_of(*k.features, k.features->grid.bounds); !problem.empty()) return problem;
  if (k.points.size() != static_cast<size_t>(k.features->size())) return "has not a place for each feature";
  if (k.colours && k.colours->size() != k.points.size()) return "has not a colour for each feature";
  if (!k.T_cw.all_finite()) return "has a pose that is not finite";
  const Eigen::Matrix3d off = k.T_cw.R().transpose() * k.T_cw.R() - Eigen::Matrix3d::Identity();
  if (!(off.cwiseAbs().maxCoeff() < 1e-3) || !(k.T_cw.R().determinant() > 0)) return "has a pose without a rotation";
  if (!is_within(k.T_cw.t(), kMaxLength)) return "has a translation beyond " + number(kMaxLength) + " m";
  if (!is_usable_stamp(k.stamp)) return "has a stamp 146 years or more from 0";
  if (k.serial >= state.next_serial) return "has a serial that is not given yet";
  if (index > 0 && k.serial <= state.key_frames[index - 1].serial) return "has a serial that does not rise";
  if (k.parent != kNone && k.parent >= frames) return "has a parent that is not there";
  if (k.parent == index) return "is its own parent";
  for (const uint32_t p : k.points) {
    if (p != kNone && p >= state.points.size()) return "observes a point that is not there";
  }
  for (size_t i = 0; i < k.loop_edges.size(); ++i) {
    if (k.loop_edges[i] >= frames || k.loop_edges[i] == index) return "has a loop edge to what is not there";
    if (i > 0 && k.loop_edges[i] <= k.loop_edges[i - 1]) return "has loop edges that do not rise";
  }
  return {};
}

std::string problem_of(const MapState& state, const MapPointState& p) {
  if (!p.position_w.allFinite() || !p.normal_w.allFinite()) return "is not finite";
  if (!is_within(p.position_w, kMaxLength)) return "has a position beyond " + number(kMaxLength) + " m";
  if (!(p.normal_w.norm() <= 1.01)) return "has a normal longer than 1, the mean of unit vectors";
  if (!std::isfinite(p.d_min) || !std::isfinite(p.d_max)) return "has a range of distances that is not finite";
  if (!(p.d_min >= 0 && p.d_min <= p.d_max)) return "has no valid range of distances";
  if (std::max(p.visible, p.found) > MapPoint::kMostFrames)
    return "has been visible or found in more frames than a run has";
  if (p.visible == 0) return "has been visible in no frame, not even where it was made";
  if (p.reference >= state.key_frames.size()) return "has a reference that is not there";
  return {};
}

}  // namespace

// Beyond it a float can't hold the levels' variances.
bool valid_pyramid(int levels, float factor) { return levels >= 1 && levels <= 32 && factor >= 1 && factor <= 4; }

bool valid_pixel_size(float base) { return base >= 1 / 64.0f && base <= 64; }

bool valid_camera(const Pinhole& c) {
  constexpr double kMaxResidual = 10;                                    // no lens is near
  constexpr double kMaxRowTime = 0.1;                                    // seconds: no camera is near
  const auto is_focal = [](double f) { return f >= 1e-3 && f <= 1e9; };  // a NaN is none
  return is_focal(c.fx) && is_focal(c.fy) && std::abs(c.cx) <= 1e9 && std::abs(c.cy) <= 1e9 && c.bf >= 0 &&
         c.bf <= kMaxLength && c.depth_noise.valid() && std::abs(c.residual.k1) <= kMaxResidual &&
         std::abs(c.residual.k2) <= kMaxResidual && c.registration.valid() && c.right_columns.valid() &&
         std::abs(c.row_time) <= kMaxRowTime;
}

std::string problem_of(const Features& f, const ImageBounds& bounds) {
  const size_t n = f.x.size();
  if (f.y.size() != n || f.image_x().size() != n || f.image_y().size() != n || f.angle.size() != n ||
      f.u_right.size() != n || f.depth.size() != n || f.level.size() != n || f.descriptor.size() != n) {
    return "has features whose lists differ in length";
  }
  if (n > kMaxFeatures) return "has more features than an image gives";
  if (!f.pyramid || !valid_pyramid(f.pyramid->levels, f.pyramid->factor) || !valid_pixel_size(f.pyramid->base) ||
      !std::isfinite(f.pyramid->sigma2.back()))
    return "has no valid pyramid";
  if (!valid_bounds(bounds)) return "has no valid image bounds";
  if (!are_pixels(f.x) || !are_pixels(f.y) || !are_pixels(f.raw_x) || !are_pixels(f.raw_y)) {
    return "has a feature outside any image";
  }
  if (!are_finite(f.angle) || !are_finite(f.u_right) || !are_finite(f.depth)) {
    return "has a feature that is not finite";
  }
  if (!are_angles(f.angle)) return "has a feature whose orientation is not from 0 to 2 pi";
  if (!are_columns(f.u_right)) return "has a feature whose column in the right image is outside any image";
  if (!are_depths(f.depth)) return "has a feature whose depth is not from 1e-12 to 1e12 m";
  if (std::any_of(f.level.begin(), f.level.end(), [&](uint8_t l) { return l >= f.pyramid->levels; })) {
    return "has a feature on a level the pyramid does not have";
  }
  return {};
}

std::string problem_of(const MapState& state) {
  if (state.key_frames.size() >= kNone || state.points.size() >= kNone) return "there is too much of it";
  if (!state.key_frames.empty() && !valid_camera(state.camera)) return "it has no valid camera";
  if (state.next_serial > kMaxSerial)
    return "its next serial is " + std::to_string(state.next_serial) + ", beyond any run";
  for (size_t i = 0; i < state.key_frames.size(); ++i) {
    if (const std::string problem = problem_of(state, i); !problem.empty()) return frame_name(i) + " " + problem;
  }
  for (size_t i = 0; i < state.points.size(); ++i) {
    const std::string problem = problem_of(state, state.points[i]);
    if (!problem.empty()) return point_name(i) + " " + problem;
  }
  // The oldest submap's root is the first that has no parent.
  uint32_t root = 0;
  while (root < state.key_frames.size() && state.key_frames[root].parent != kNone) ++root;
  if (state.root != (root < state.key_frames.size() ? root : kNone)) return "it has no root";
  if (root == state.key_frames.size() && root > 0) return "it has no root";
  return {};
}

MapState Map::state() const {
  MapState state;
  state.next_serial = next_serial_;
  state.camera = camera_;
  const std::vector<KeyFrameId> frames = key_frames();
  std::vector<uint32_t> frame_index, point_index;  // by slot
  for (size_t i = 0; i < frames.size(); ++i) {
    frame_index.resize(std::max<size_t>(frame_index.size(), frames[i].slot + size_t{1}));
    frame_index[frames[i].slot] = static_cast<uint32_t>(i);
  }
  state.points.reserve(points_.size());
  for_each_point([&](MapPointId id, const MapPoint& p) {
    point_index.resize(id.slot + size_t{1});
    point_index[id.slot] = static_cast<uint32_t>(state.points.size());
    state.points.push_back(
        {p.position_w, p.normal_w, p.descriptor, p.d_min, p.d_max, frame_index[p.reference.slot], p.visible, p.found});
  });
  state.key_frames.reserve(frames.size());
  for (const KeyFrameId& id : frames) {
    const KeyFrame& k = at(id);
    KeyFrameState& s = state.key_frames.emplace_back(
        KeyFrameState{k.serial, k.frame, k.stamp, k.T_cw, k.features, {}, kNone, {}, k.colours});
    if (k.parent.valid()) s.parent = frame_index[k.parent.slot];
    s.points.reserve(k.points.size());
    for (const MapPointId& p : k.points) s.points.push_back(p.valid() ? point_index[p.slot] : kNone);
    for (const KeyFrameId& other : k.loop_edges) s.loop_edges.push_back(frame_index[other.slot]);
    std::sort(s.loop_edges.begin(), s.loop_edges.end());
  }
  if (root().valid()) state.root = frame_index[root().slot];
  return state;
}

void Map::rebuild_shared() {
  // Slots are dense in a map just put together, so that a flat list can count.
  std::vector<int> weights(key_frames_.size());
  std::vector<KeyFrameId> met;
  for (const KeyFrameId& id : key_frames()) {
    KeyFrame& key_frame = key_frames_.at(id);
    met.clear();
    for (const MapPointId& point : key_frame.points) {
      if (!point.valid()) continue;
      for (const Observation& o : at(point).observations) {
        if (o.key_frame != id && weights[o.key_frame.slot]++ == 0) met.push_back(o.key_frame);
      }
    }
    std::sort(met.begin(), met.end());
    key_frame.shared.clear();
    for (const KeyFrameId& other : met) {
      key_frame.shared.push_back({other, weights[other.slot]});
      weights[other.slot] = 0;
    }
  }
}

// Each key frame without a parent is the root of a submap, numbered as they come.
void Map::find_submaps(const std::vector<KeyFrameId>& frames) {
  for (const KeyFrameId& root : frames) {
    if (at(root).parent.valid()) continue;
    std::vector<KeyFrameId> tree{root};
    for (size_t k = 0; k < tree.size(); ++k) {
      KeyFrame& key_frame = key_frames_.at(tree[k]);
      key_frame.submap = next_submap_;
      tree.insert(tree.end(), key_frame.children.begin(), key_frame.children.end());
    }
    submaps_.push_back({next_submap_++, root, tree.size()});
  }
}

Result<Map> Map::from_state(MapState state) {
  if (const std::string problem = problem_of(state); !problem.empty()) return fail(problem);
  Map map;
  std::vector<KeyFrameId> frames;
  std::vector<MapPointId> points;
  std::vector<uint32_t> observations(state.points.size());
  for (const KeyFrameState& s : state.key_frames) {
    for (const uint32_t point : s.points) {
      if (point != kNone) ++observations[point];
    }
  }
  frames.reserve(state.key_frames.size());
  points.reserve(state.points.size());
  for (const MapPointState& p : state.points) {
    MapPoint point;
    // In the order in which they are read later: what grows a piece at a time is scattered over a large map's memory.
    point.observations.reserve(observations[points.size()]);
    point.position_w = p.position_w;
    point.normal_w = p.normal_w;
    point.descriptor = p.descriptor;
    point.d_min = p.d_min;
    point.d_max = p.d_max;
    point.visible = p.visible;
    point.found = p.found;
    points.push_back(map.points_.insert(std::move(point)));
  }
  for (KeyFrameState& s : state.key_frames) {
    KeyFrame key_frame;
    key_frame.serial = s.serial;
    key_frame.frame = s.frame;
    key_frame.stamp = s.stamp;
    key_frame.T_cw = s.T_cw;
    key_frame.features = std::move(s.features);
    key_frame.colours = std::move(s.colours);
    key_frame.points.resize(s.points.size());
    frames.push_back(map.key_frames_.insert(std::move(key_frame)));
    KeyFrame& made = map.key_frames_.at(frames.back());
    for (uint32_t f = 0; f < s.points.size(); ++f) {
      if (s.points[f] == kNone) continue;
      made.points[f] = points[s.points[f]];
      map.points_.at(made.points[f]).observations.push_back({frames.back(), f});  // sorted: handles rise here
    }
  }
  for (size_t i = 0; i < frames.size(); ++i) {
    KeyFrame& key_frame = map.key_frames_.at(frames[i]);
    for (const uint32_t other : state.key_frames[i].loop_edges) key_frame.loop_edges.push_back(frames[other]);
    if (state.key_frames[i].parent == kNone) continue;
    key_frame.parent = frames[state.key_frames[i].parent];
    map.key_frames_.at(key_frame.parent).children.push_back(frames[i]);
  }
  for (size_t i = 0; i < points.size(); ++i) map.points_.at(points[i]).reference = frames[state.points[i].reference];
  map.next_serial_ = state.next_serial;
  map.camera_ = state.camera;
  map.find_submaps(frames);
  map.rebuild_shared();
  if (const std::string problem = map.check(); !problem.empty()) return fail(problem);
  return map;
}

}  // namespace covis
