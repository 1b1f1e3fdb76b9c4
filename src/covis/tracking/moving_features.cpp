// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/moving_features.h"

#include <algorithm>
#include <cmath>

#include "covis/core/reserve.h"
#include "covis/geometry/measurement.h"

namespace covis {
namespace {

constexpr double kRadius = 0.15;  // radians, about: features of one thing are so near
constexpr float kDepth = 0.1f;    // share of its depth by which another feature of one thing may be nearer or farther

// Calls visit(k) for each feature of about the same depth in a square around feature i, itself among them.
template <class Visit>
void for_each_beside(const Features& f, size_t i, float radius, Visit&& visit) {
  f.grid.for_each_run(f.x[i], f.y[i], radius, [&](uint32_t first, uint32_t last) {
    for (uint32_t at = first; at < last; ++at) {
      const size_t k = f.grid.indices[at];
      if (std::abs(f.x[k] - f.x[i]) > radius || std::abs(f.y[k] - f.y[i]) > radius) continue;
      if (std::abs(f.depth[k] - f.depth[i]) <= kDepth * f.depth[i]) visit(k);
    }
  });
}

// True when the features around this one lie along the direction in which it was displaced.
bool is_along_line(const Features& f, size_t i, const Eigen::Vector2d& direction, float radius) {
  constexpr double kShare = 0.15;   // of the squares of their distances, across that direction
  constexpr double kSamePlace = 3;  // pixels: corners of several levels lie at one place
  constexpr int kEnough = 2;
  double across = 0, all = 0;
  int count = 0;
  for_each_beside(f, i, radius, [&](size_t k) {
    const Eigen::Vector2d to(f.x[k] - f.x[i], f.y[k] - f.y[i]);
    if (to.squaredNorm() < kSamePlace * kSamePlace) return;
    const double side = to.x() * direction.y() - to.y() * direction.x();
    across += side * side;
    all += to.squaredNorm();
    ++count;
  });
  return count >= kEnough && across < kShare * all;
}

// Depth that is nonsense, or a pose that is wrong, displaces all of a young map's points: those of one key frame say
// nothing of what stands.
bool is_held_by_settled_points(const TrackedFrame& frame, const LocalMap& local_map) {
  constexpr int kEnough = 30;
  int settled = 0;
  for (size_t i = 0; i < frame.source.size(); ++i)
    settled += frame.on_map(i) && !frame.moves(i) && !local_map.is_new(frame.points[i]);
  return settled >= kEnough;
}

}  // namespace

// Reserves room in advance; its memory is used only when features come.
MovingFeatures::MovingFeatures() {
  constexpr size_t kFeatures = 1 << 12;
  displaced_.reserve(kFeatures);
  displaced_of_.reserve(kFeatures);
  moving_.reserve(kFeatures);
  looked_at_.reserve(kFeatures);
  spread_.reserve(kFeatures);
}

void MovingFeatures::find_displaced(const TrackedFrame& frame, const Pinhole& camera) {
  const Features& f = *frame.features;
  const size_t n = frame.source.size();
  displaced_.clear();
  reserve_ahead(displaced_, n);
  reserve_ahead(displaced_of_, n);
  displaced_of_.assign(n, -1);
  for (size_t i = 0; i < n; ++i) {
    if (!frame.was_refused[i] || !(f.depth[i] > 0)) continue;
    const Eigen::Vector3d p = frame.T_cw * frame.positions[i];
    if (!(p.z() > 0)) continue;
    const Eigen::Vector2d by = Eigen::Vector2d(f.x[i], f.y[i]) - camera.project(p);
    if (by.squaredNorm() * static_cast<double>(f.pyramid->inv_sigma2[f.level[i]]) <= kChi2Mono) continue;
    displaced_of_[i] = static_cast<int32_t>(displaced_.size());
    displaced_.push_back({static_cast<uint32_t>(i), by});
  }
}

bool MovingFeatures::moves_with_others(const TrackedFrame& frame, const Displaced& displaced, float radius) const {
  constexpr int kEnough = 4;          // matches displaced alike
  constexpr double kAlike = 1.5;      // sigmas of a keypoint
  constexpr float kLineShare = 0.4f;  // of the radius: a line is looked for nearer
  const Features& f = *frame.features;
  int alike = 0, still = 0;
  for_each_beside(f, displaced.feature, radius, [&](size_t k) {
    if (frame.source[k] != PointSource::none) {
      still += !frame.moves(k);
    } else if (displaced_of_[k] >= 0) {
      const auto level = std::max(f.level[displaced.feature], f.level[k]);
      const double bound = kAlike * kAlike * static_cast<double>(f.pyramid->sigma2[level]);
      alike += (displaced_[static_cast<size_t>(displaced_of_[k])].by - displaced.by).squaredNorm() < bound;
    }
  });
  return alike >= kEnough && alike > still &&
         !is_along_line(f, displaced.feature, displaced.by.normalized(), kLineShare * radius);
}

// A feature among others that move, more of them than of those that agree with the pose, moves with them.
void MovingFeatures::spread(TrackedFrame& frame, float radius) {
  constexpr int kEnough = 2;
  const Features& f = *frame.features;
  const size_t n = frame.source.size();
  reserve_ahead(spread_, n);
  reserve_ahead(looked_at_, n);
  spread_ = frame.moved;
  looked_at_.assign(n, 0);
  for (const uint32_t moving : moving_) {
    for_each_beside(f, moving, radius, [&](size_t i) {
      if (looked_at_[i]) return;
      looked_at_[i] = 1;
      Timestamp last = TrackedFrame::kNever;
      int with = 0, still = 0;
      for_each_beside(f, i, radius, [&](size_t k) {
        if (frame.moves(k)) {
          ++with;
          last = std::max(last, frame.moved[k]);
        } else {
          still += frame.source[k] != PointSource::none;
        }
      });
      if (with >= kEnough && with > still) spread_[i] = std::max(spread_[i], last);
    });
  }
  std::swap(frame.moved, spread_);
}

void MovingFeatures::find(TrackedFrame& frame, const LocalMap& local_map, const Pinhole& camera) {
  if (!(camera.bf > 0) || !is_held_by_settled_points(frame, local_map)) return;
  const auto radius = static_cast<float>(kRadius * camera.fx);
  find_displaced(frame, camera);
  moving_.clear();
  reserve_ahead(moving_, frame.source.size());
  for (const Displaced& displaced : displaced_) {
    if (moves_with_others(frame, displaced, radius)) moving_.push_back(displaced.feature);
  }
  for (const uint32_t i : moving_) frame.moved[i] = frame.stamp;
  moving_.clear();
  for (uint32_t i = 0; i < static_cast<uint32_t>(frame.moved.size()); ++i) {
    if (frame.moves(i) && frame.features->depth[i] > 0) moving_.push_back(i);
  }
  if (!moving_.empty()) spread(frame, radius);
}

}  // namespace covis
