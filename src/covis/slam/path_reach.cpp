// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/path_reach.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "covis/core/quantile.h"
#include "covis/geometry/se3.h"

namespace covis {
namespace {

double seconds_between(const PoseOfFrame& a, const PoseOfFrame& b) {
  return std::abs(to_seconds(a.stamp) - to_seconds(b.stamp));
}

double distance(const PoseOfFrame& a, const PoseOfFrame& b) { return (a.T_wc.t() - b.T_wc.t()).norm(); }

double angle(const PoseOfFrame& a, const PoseOfFrame& b) { return so3_log(a.T_wc.R().transpose() * b.T_wc.R()).norm(); }

// Seconds after which the camera may be at a look-alike.
double longest_time(const std::vector<PoseOfFrame>& path) {
  constexpr double kLongest = 0.35, kIntervals = 1.5;
  std::vector<double> intervals;
  for (size_t k = 1; k < path.size(); ++k) intervals.push_back(seconds_between(path[k - 1], path[k]));
  return intervals.empty() ? kLongest : std::max(kLongest, kIntervals * quantile(std::move(intervals), 0.5));
}

}  // namespace

PathReach::PathReach(std::vector<PoseOfFrame> path) : path_(std::move(path)), longest_(longest_time(path_)) {
  constexpr double kNearlyAll = 0.95;
  struct Speeds {
    std::vector<double> forward, turning;
  };
  std::map<uint32_t, Speeds> of;
  for (size_t k = 1; k < path_.size(); ++k) {
    const PoseOfFrame &a = path_[k - 1], &b = path_[k];
    const double elapsed = seconds_between(a, b);
    if (a.submap != b.submap || !(elapsed > 0) || elapsed > longest_) continue;
    of[b.submap].forward.push_back(distance(a, b) / elapsed);
    of[b.submap].turning.push_back(angle(a, b) / elapsed);
  }
  for (auto& [submap, speeds] : of)
    most_[submap] = {quantile(std::move(speeds.forward), kNearlyAll), quantile(std::move(speeds.turning), kNearlyAll)};
}

bool PathReach::reaches(const PoseOfFrame& from, const PoseOfFrame& to) const {
  constexpr double kFaster = 1.5;
  const auto most = most_.find(to.submap);
  // Poses of single images are off by millimetres, which a fast camera's do not pass from frame to frame.
  constexpr double kShortest = 1.0 / 30;  // seconds
  const double elapsed = std::max(seconds_between(from, to), kShortest);
  return most != most_.end() && distance(from, to) <= kFaster * most->second.forward * elapsed &&
         angle(from, to) <= kFaster * most->second.turning * elapsed;
}

bool PathReach::admits(const PoseOfFrame& pose) const {
  const PoseOfFrame *before = nullptr, *after = nullptr;
  for (const PoseOfFrame& other : path_) {
    if (other.submap != pose.submap || seconds_between(other, pose) > longest_) continue;
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
