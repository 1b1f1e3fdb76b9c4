// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/frames_between.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace covis {
namespace {

// Moves a camera at T_cw with a key frame.
SE3 moved(const SE3& T_cw, const KeyFrameMove& by) {
  const SE3 T_ck = T_cw * by.before.inverse();
  return SE3(T_ck.R(), Eigen::Vector3d(by.scale_after / by.scale_before * T_ck.t())) * by.after;
}

double turn(const SE3& a, const SE3& b) { return so3_log(a.R() * b.R().transpose()).norm(); }
double way(const SE3& a, const SE3& b) { return (a.centre() - b.centre()).norm(); }

}  // namespace

FramesBetween::FramesBetween(const std::vector<KeyFrameMove>& moves, std::vector<KeyFrameMove> own)
    : own_(std::move(own)) {
  for (const KeyFrameMove& move : moves) of_.emplace(move.key_frame, move);
  std::ranges::sort(own_, {}, &KeyFrameMove::frame);
}

std::optional<RelativePose> FramesBetween::carried(const Map& map, int64_t frame, const RelativePose& pose) const {
  const auto living = map.resolve(pose.key_frame);
  const auto found = living ? of_.find(living->key_frame) : of_.end();
  if (found == of_.end()) return std::nullopt;
  const KeyFrameMove& reference = found->second;
  const SE3 T_cr_now = living->carry(pose.T_cr, pose.scale);
  const double shrinkage = reference.scale_before / map.at(living->key_frame).scale;
  const SE3 T_cw = SE3(T_cr_now.R(), Eigen::Vector3d(shrinkage * T_cr_now.t())) * reference.before;
  const SE3 by_reference = moved(T_cw, reference);
  const auto made = [&](const SE3& now) {
    return RelativePose{living->key_frame, reference.scale_after, now * reference.after.inverse()};
  };
  const auto next = std::ranges::upper_bound(own_, frame, {}, &KeyFrameMove::frame);
  if (next == own_.begin() || next == own_.end()) return made(by_reference);

  const KeyFrameMove &before = *std::prev(next), &after = *next;
  constexpr double kTiny = 1e-9;
  const double length = std::max(way(before.before, after.before), kTiny),
               angle = std::max(turn(before.before, after.before), kTiny);
  double weights = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), rotation = Eigen::Vector3d::Zero();
  const auto add = [&](const KeyFrameMove& key_frame) {
    const double distance = way(T_cw, key_frame.before) / length + turn(T_cw, key_frame.before) / angle;
    const double weight = 1 / (distance * distance + kTiny);
    const SE3 now = moved(T_cw, key_frame);
    centre += weight * now.centre();
    rotation += weight * so3_log(now.R() * by_reference.R().transpose());
    weights += weight;
  };
  add(before);
  add(after);
  if (reference.key_frame != before.key_frame && reference.key_frame != after.key_frame) add(reference);
  const Eigen::Matrix3d R = so3_exp(rotation / weights) * by_reference.R();
  return made(SE3(R, Eigen::Vector3d(-(R * centre) / weights)).normalized());
}

}  // namespace covis
