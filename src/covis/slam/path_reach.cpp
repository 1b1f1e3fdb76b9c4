// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/path_reach.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "covis/core/quantile.h"
#include "covis/geometry/se3.h"

namespace covis {
namespace {

constexpr double kLongest = 0.35;  // seconds: after a longer time the camera may be at a look-alike

double seconds_between(const PoseOfFrame& a, const PoseOfFrame& b) {
  return std::abs(to_seconds(a.stamp) - to_seconds(b.stamp));
}

double distance(const PoseOfFrame& a, const PoseOfFrame& b) { return (a.T_wc.t() - b.T_wc.t()).norm(); }

double angle(const PoseOfFrame& a, const PoseOfFrame& b) { return so3_log(a.T_wc.R().transpose() * b.T_wc.R()).norm(); }

}  // namespace

PathReach::PathReach(std::vector<PoseOfFrame> path) : path_(std::move(path)) {
  constexpr double kNearlyAll = 0.95;
  struct Speeds {
    std::vector<double> forward, turning;
  };
  std::map<uint32_t, Speeds> of;
  for (size_t k = 1; k < path_.size(); ++k) {
    const PoseOfFrame &a = path_[k - 1], &b = path_[k];
    const double elapsed = seconds_between(a, b);
    if (a.submap != b.submap || !(elapsed > 0) || elapsed > kLongest) continue;
    of[b.submap].forward.push_back(distance(a, b) / elapsed);
    of[b.submap].turning.push_back(angle(a, b) / elapsed);
  }
  for (auto& [submap, speeds] : of)
    most_[submap] = {quantile(std::move(speeds.forward), kNearlyAll), quantile(std::move(speeds.turning), kNearlyAll)};
}

bool PathReach::reaches(const PoseOfFrame& from, const PoseOfFrame& to) const {
  constexpr double kFaster = 1.5;
  const auto most = most_.find(to.submap);
  const double elapsed = seconds_between(from, to);
  return most != most_.end() && distance(from, to) <= kFaster * most->second.forward * elapsed &&
         angle(from, to) <= kFaster * most->second.turning * elapsed;
}

bool PathReach::admits(const PoseOfFrame& pose) const {
  const PoseOfFrame *before = nullptr, *after = nullptr;
  for (const PoseOfFrame& other : path_) {
    if (other.submap != pose.submap || seconds_between(other, pose) > kLongest) continue;
    if (other.stamp < pose.stamp) {
      before = &other;
    } else if (other.stamp > pose.stamp && !after) {
      after = &other;
    }
  }
  return (before || after) && (!before || reaches(*before, pose)) && (!after || reaches(*after, pose));
}

void PathReach::add(const PoseOfFrame& pose) {
  path_.insert(std::ranges::upper_bound(path_, pose.stamp, {}, &PoseOfFrame::stamp), pose);
}

}  // namespace covis
