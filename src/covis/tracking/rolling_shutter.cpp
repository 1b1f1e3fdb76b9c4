// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/rolling_shutter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "covis/core/log.h"
#include "covis/features/unrolling.h"
#include "covis/optimization/reprojection.h"
#include "covis/tracking/motion_model.h"

namespace covis {
namespace {

constexpr int kFewestMatches = 30;
constexpr int kFramesOfBlock = 10;                   // frames whose residuals err alike
constexpr int kFewestBlocks = 8;                     // before anything is believed
constexpr double kSure = 6;                          // standard deviations
constexpr double kShortest = 0.005, kLongest = 0.1;  // seconds
constexpr double kMostTurn = 0.3;                    // radians an image: a faster turn is that of a wrong pose

}  // namespace

FeaturesPtr RollingShutter::straighten(FeaturesPtr features, const Pinhole& camera,
                                       const std::optional<Eigen::Vector3d>& turn_rate) {
  taken_.setZero();
  if (readout_ == 0 || !turn_rate || !(std::abs(readout_) * turn_rate->norm() < kMostTurn)) return features;
  taken_ = readout_ * *turn_rate;
  const std::shared_ptr<Features> straight = ring_.copy_of(*features);
  unroll(camera, taken_ / rows_, *straight);
  return straight;
}

const RollingShutter::Turn* RollingShutter::turn_of(Timestamp stamp) const {
  const auto at = std::ranges::lower_bound(key_frames_, stamp, {}, &Turn::stamp);
  return at != key_frames_.end() && at->stamp == stamp ? &*at : nullptr;
}

void RollingShutter::follow(const Step& step, const Pinhole& camera, const SharedMap* live,
                            std::optional<uint64_t> moves) {
  const TrackedFrame& frame = step.frame;
  const Timestamp elapsed = frame.stamp - step.before;
  if (!finds_ || elapsed <= 0) return;
  const Eigen::Vector3d turn_rate = MotionModel::turn_rate(frame.T_cw * step.T_lw.inverse(), elapsed);
  if (live) {
    const auto map = live->read();
    if (!moves || map->moves() == *moves) compare(frame, camera, turn_rate, *map, step.reference);
  }
  if (step.becomes_key_frame && (key_frames_.empty() || key_frames_.back().stamp < frame.stamp))
    key_frames_.push_back({frame.stamp, turn_rate, taken_});
}

// The keypoints of both views are compared, with nothing of the map but depths: poses and points have taken up what the
// shutter did to many views. The motion between the two is eliminated.
void RollingShutter::compare(const TrackedFrame& frame, const Pinhole& camera, const Eigen::Vector3d& turn_rate,
                             const Map& map, KeyFrameId reference) {
  const KeyFrame* key_frame = map.find(reference);
  const Turn* then = key_frame ? turn_of(key_frame->stamp) : nullptr;
  if (!then) return;
  const Features &f = *frame.features, &f_r = *key_frame->features;
  const SE3 T_cr = frame.T_cw * key_frame->T_cw.inverse();
  Matrix6d H = Matrix6d::Zero();
  Vector6d h = Vector6d::Zero(), b = Vector6d::Zero();
  Sums sums;
  int matches = 0;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    const MapPoint* point = frame.on_map(i) ? map.find(frame.points[i]) : nullptr;
    if (!point || !point->seen_by(reference)) continue;
    const size_t k = point->feature_in(reference);
    const double depth = (key_frame->T_cw * point->position_w).z();
    const Eigen::Vector3d p_r = depth * camera.unproject(f_r.x[k], f_r.y[k]);
    const Eigen::Vector3d p = T_cr * p_r;
    if (depth <= 0 || p.z() <= 0) continue;
    const double row = (f.image_y()[i] - camera.cy) / rows_, row_then = (f_r.image_y()[k] - camera.cy) / rows_;
    // The move of the point where these are the turns of both views from the first row to the last.
    const auto moved = [&](const Eigen::Vector3d& now, const Eigen::Vector3d& before) {
      return Eigen::Vector3d(row * now.cross(p) - row_then * (T_cr.R() * before.cross(p_r)));
    };
    const Eigen::Matrix3d J_pi = projection_jacobian(p, camera, {});
    const Eigen::Matrix<double, 2, 6> J = pose_jacobian(J_pi, p).topRows<2>();
    const Eigen::Vector2d g = J_pi.topRows<2>() * moved(turn_rate, then->rate);
    const Eigen::Vector2d e =
        Eigen::Vector2d(f.x[i], f.y[i]) - camera.project(p) + J_pi.topRows<2>() * moved(taken_, then->taken);
    const double weight = f.pyramid->inv_sigma2[f.level[i]];
    H += weight * J.transpose() * J;
    h += weight * J.transpose() * g;
    b += weight * J.transpose() * e;
    sums.curvature += weight * g.squaredNorm();
    sums.slope += weight * g.dot(e);
    ++matches;
  }
  if (matches < kFewestMatches) return;
  const Vector6d explained = H.ldlt().solve(h);
  if (!explained.allFinite()) return;
  block_.curvature += sums.curvature - h.dot(explained);
  block_.slope += sums.slope - b.dot(explained);
  if (++frames_ == kFramesOfBlock) end_block();
}

// Residuals of neighbouring frames err alike: the variance is that of the blocks.
void RollingShutter::end_block() {
  Blocks& b = blocks_;
  ++b.count;
  b.all.curvature += block_.curvature;
  b.all.slope += block_.slope;
  b.curvature2 += block_.curvature * block_.curvature;
  b.product += block_.curvature * block_.slope;
  b.slope2 += block_.slope * block_.slope;
  block_ = {};
  frames_ = 0;
  if (b.count < kFewestBlocks || b.all.curvature <= 0) return;
  const double readout = b.all.slope / b.all.curvature;
  const double variance = b.slope2 - 2 * readout * b.product + readout * readout * b.curvature2;
  const double sigma = std::sqrt(std::max(0.0, variance)) / b.all.curvature;
  const double size = std::abs(readout);
  if (size < kSure * sigma || size < kShortest || size > kLongest) return;
  if (readout_ == 0) {
    std::array<char, 120> text{};
    std::snprintf(text.data(), text.size(),
                  "rolling shutter found: %.4f seconds from the first row to the last (tracker.readout)", readout);
    log(LogLevel::info, text.data());
  }
  readout_ = readout;
}

}  // namespace covis
