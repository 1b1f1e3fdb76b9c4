// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_candidate.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "covis/core/quantile.h"

namespace covis {
namespace {

constexpr size_t kGroupMatching = 6;  // key frames of a place that are matched against
constexpr int kGroupPoints = 15;      // covisible key frames of a place whose points are projected
constexpr int kNeighbours = 5;        // key frames beside the current one that are asked

}  // namespace

Travel travel_between(const Map& map, uint32_t submap, uint32_t serial_a, uint32_t serial_b) {
  const auto [first, last] = std::minmax(serial_a, serial_b);
  Travel travel;
  std::optional<SE3> before;
  for (const KeyFrameId& id : map.key_frames(submap)) {
    const KeyFrame& key_frame = map.at(id);
    if (key_frame.serial < first || key_frame.serial > last) continue;
    if (before) {
      travel.length += (key_frame.T_cw.centre() - before->centre()).norm();
      travel.turned += so3_log(key_frame.T_cw.R() * before->R().transpose()).norm();
    }
    before = key_frame.T_cw;
  }
  return travel;
}

double median_depth(const Loop& loop) {
  std::vector<double> depths;
  const SE3 T_cw = loop.S_cw.as_pose();
  for (const auto& [feature, id] : loop.matches) {
    const int32_t at = index_of(loop.place.points, id);
    depths.push_back((T_cw * loop.place.points.position(static_cast<size_t>(at))).z());
  }
  return quantile(std::move(depths), 0.5);
}

LoopPlace::LoopPlace(const Map& map, KeyFrameId id) : key_frame(id), T_cw(map.at(id).T_cw), group{id} {
  for (const Neighbour& n : map.best_neighbours(id, kGroupPoints)) group.push_back(n.key_frame);
  points.id = points_of(map, group);
  points.copy(map);
}

LoopCandidate::LoopCandidate(const Map& map, KeyFrameId from, KeyFrameId to)
    : camera(map.camera()), frame(map.at(from).frame), current(map, from), place(map, to), here(map, from) {
  for (size_t g = 0; g < place.group.size() && g < kGroupMatching; ++g) members.emplace_back(map, place.group[g]);
  for (const Neighbour& n : map.best_neighbours(from, kNeighbours)) neighbours.emplace_back(map, n.key_frame);
  if (map.at(from).submap == map.at(to).submap) {
    travel = travel_between(map, map.at(from).submap, map.at(from).serial, map.at(to).serial);
  } else {
    relation = LoopRelation::other_submap;
  }
}

}  // namespace covis
