// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/frames_between.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace covis {
namespace {

SE3 in_lengths(double factor, const SE3& T) { return SE3(T.R(), Eigen::Vector3d(factor * T.t())); }

// Moves a camera at T_cw with a key frame, around which lengths grew.
SE3 moved(const SE3& T_cw, const KeyFrameMove& by, double growth) {
  return in_lengths(growth, T_cw * by.before.inverse()) * by.after;
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
  // The reference may have been erased since it moved; one that was erased before is followed to the one that lives.
  auto found = of_.find(pose.key_frame);
  std::optional<Map::Resolved> living;
  if (found == of_.end()) {
    living = map.resolve(pose.key_frame);
    found = living ? of_.find(living->key_frame) : of_.end();
  }
  if (found == of_.end()) return std::nullopt;
  const KeyFrameMove& reference = found->second;
  const SE3 T_cr =
      living ? in_lengths(reference.scale / map.at(living->key_frame).scale, living->carry(pose.T_cr, pose.scale))
             : in_lengths(reference.scale / pose.scale, pose.T_cr);
  const SE3 T_cw = T_cr * reference.before;
  const auto made = [&](const SE3& now) {
    return RelativePose{reference.key_frame, reference.scale, now * reference.after.inverse()};
  };
  const auto next = std::ranges::upper_bound(own_, frame, {}, &KeyFrameMove::frame);
  if (next == own_.begin() || next == own_.end()) return made(moved(T_cw, reference, 1));

  constexpr double kTiny = 1e-9, kMostGrowth = 2;  // bounds what a camera that hardly moved would say of lengths
  const KeyFrameMove &before = *std::prev(next), &after = *next;
  const double length = std::max(way(before.before, after.before), kTiny),
               angle = std::max(turn(before.before, after.before), kTiny),
               growth = std::clamp(way(before.after, after.after) / length, 1 / kMostGrowth, kMostGrowth);
  const SE3 by_reference = moved(T_cw, reference, growth);
  double weights = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), rotation = Eigen::Vector3d::Zero();
  const auto add = [&](const KeyFrameMove& key_frame) {
    const double distance = way(T_cw, key_frame.before) / length + turn(T_cw, key_frame.before) / angle;
    const double weight = 1 / (distance * distance + kTiny);
    const SE3 now = moved(T_cw, key_frame, growth);
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
