// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/rolling_shutter.h"

#include <algorithm>
#include <cmath>

#include "covis/features/unrolling.h"
#include "covis/optimization/reprojection.h"
#include "covis/tracking/motion_model.h"

namespace covis {
namespace {

constexpr double kMostTurn = 0.3;    // radians an image: a faster turn is that of a wrong pose
constexpr double kFastest = 10;      // radians a second: the same
constexpr double kRemembered = 0.5;  // seconds: after a longer pause the camera turns in another way

bool may_be(const Eigen::Vector3d& rate, double readout) {
  return !rate.isZero(0) && rate.norm() < kFastest && std::abs(readout) * rate.norm() < kMostTurn;
}

}  // namespace

FeaturesPtr RollingShutter::straighten(FeaturesPtr features, const Pinhole& camera, Timestamp stamp) {
  straight_ = nullptr;
  if (to_seconds(std::abs(stamp - stamp_)) > kRemembered) rate_.setZero();
  if (camera.row_time == 0) return features;
  straight_ = ring_.copy_of(*features);
  unroll(camera, {rate_, camera.row_time}, *straight_);
  return straight_;
}

// The motion from frame to frame is noisy, and the noise would come back with the next pose.
void RollingShutter::follow(const Last& last, const Pinhole& camera, const TrackedFrame& frame) {
  constexpr double kSmooth = 1.0 / 30;  // seconds
  const Timestamp elapsed = frame.stamp - last.stamp;
  if (elapsed <= 0 || to_seconds(elapsed) > kRemembered) return;
  const Eigen::Vector3d rate = MotionModel::turn_rate(frame.T_cw * last.T_cw.inverse(), elapsed);
  const bool goes_on = !rate_.isZero(0) && stamp_ == last.stamp;
  const double weight = goes_on ? to_seconds(elapsed) / (to_seconds(elapsed) + kSmooth) : 1;
  rate_ += weight * (rate - rate_);
  stamp_ = frame.stamp;
  if (!may_be(rate_, camera.row_time * options_.rows)) rate_.setZero();
  if (camera.row_time != 0 && straight_ == frame.features) unroll(camera, {rate_, camera.row_time}, *straight_);
}

// The keypoints of both views are compared, with nothing of the map but depths: poses and points have taken up what the
// shutter did to many views. The motion between the two is eliminated.
ShutterResponse RollingShutter::compare(const TrackedFrame& frame, const Pinhole& camera, const Map& map,
                                        KeyFrameId reference) {
  const KeyFrame* key_frame = map.find(reference);
  if (options_.row_time == ShutterOptions::RowTime::given || !key_frame || rate_.isZero(0)) return {};
  // What is estimated depends on whether a row time is in use, little on which.
  if ((camera.row_time == 0) != (estimated_with_ == 0)) estimate_.restart();
  estimated_with_ = camera.row_time;
  const Features &f = *frame.features, &f_r = *key_frame->features;
  const Eigen::Vector3d& rate_then = f_r.exposure.rate;
  if (rate_then.isZero(0)) return {};
  const Eigen::Vector3d taken = options_.rows * f.exposure.taken(), taken_then = options_.rows * f_r.exposure.taken();
  const SE3 T_cr = frame.T_cw * key_frame->T_cw.inverse();
  comparison_.start(frame.source.size());
  const auto add = [&](size_t i, MapPointId id) {
    const MapPoint* point = map.find(id);
    if (!point || !point->seen_by(reference)) return;
    const size_t k = point->feature_in(reference);
    const double depth = (key_frame->T_cw * point->position_w).z();
    const Eigen::Vector3d p_r = depth * camera.unproject(f_r.x[k], f_r.y[k]);
    const Eigen::Vector3d p = T_cr * p_r;
    if (depth <= 0 || p.z() <= 0) return;
    const double row = (f.image_y()[i] - camera.cy) / options_.rows,
                 row_then = (f_r.image_y()[k] - camera.cy) / options_.rows;
    // The move of the point where these are the turns of both views from the first row to the last.
    const auto moved = [&](const Eigen::Vector3d& now, const Eigen::Vector3d& before) {
      return Eigen::Vector3d(row * now.cross(p) - row_then * (T_cr.R() * before.cross(p_r)));
    };
    const Eigen::Matrix3d J_pi = projection_jacobian(p, camera, {});
    ReadoutComparison::Match match{.by_motion = pose_jacobian(J_pi, p).topRows<2>(), .by_shutter = {}};
    match.by_shutter << J_pi.topRows<2>() * moved(rate_, rate_then),
        Eigen::Vector2d(0, 1) - depth / camera.fy * J_pi.topRows<2>() * T_cr.R().col(1),
        Eigen::Vector2d(f.x[i], f.y[i]) - camera.project(p) + J_pi.topRows<2>() * moved(taken, taken_then);
    match.information = f.pyramid->inv_sigma2[f.level[i]];
    comparison_.add(match);
  };
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (frame.on_map(i)) add(i, frame.points[i]);
  }
  for (const TrackedFrame::Refused& refused : frame.refused) {
    if (!frame.on_map(refused.feature)) add(refused.feature, refused.point);
  }
  const auto compared = comparison_.result(camera.row_time * options_.rows);
  if (!compared) return {};
  estimate_.add(compared->equations);
  return {(-options_.rows * compared->motion).cast<float>(), camera.row_time};
}

std::optional<ShutterChange> RollingShutter::found(const Pinhole& camera) const {
  constexpr double kLeastChange = 0.1;                 // as a share
  constexpr double kShortest = 0.005, kLongest = 0.1;  // seconds
  constexpr double kNone = 0.0025;                     // seconds: what was found is kept down to here
  constexpr double kLeastBlocks = 8;                   // fewest that tell that it is another
  constexpr double kLikely = 0.4;                      // share of by_chance() that a better value is to differ by
  if (options_.row_time == ShutterOptions::RowTime::given || camera.row_time != estimated_with_) return std::nullopt;
  const std::optional<ReadoutEstimate::Value> value = estimate_.value();
  if (!value) return std::nullopt;
  const double present = camera.row_time * options_.rows, size = std::abs(value->readout);
  const double least = present == 0 ? kShortest : kNone;
  const bool is_there = size > value->sure() && size >= least && size <= kLongest;
  const double change = std::abs(value->readout - present);
  const ShutterChange another{camera.row_time, value->readout / options_.rows}, none{camera.row_time, 0};
  if (present == 0) return is_there ? std::optional(another) : std::nullopt;
  if (value->blocks < kLeastBlocks) return std::nullopt;
  if (is_there && change > kLeastChange * std::abs(present) && change > kLikely * value->by_chance()) return another;
  return !is_there && change > value->by_chance() ? std::optional(none) : std::nullopt;
}

}  // namespace covis
