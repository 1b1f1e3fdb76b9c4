// SPDX-License-Identifier: Apache-2.0
// Closing a recognised loop: the pose graph over Sim(3), the points carried along, and both places' points fused.
// Joining two submaps that turn out to show one place.
// Sources: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, sections VII-C and VII-D; Strasdat et al., RSS 2010 (pose
// graph over Sim(3)).
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "covis/core/sensor.h"
#include "covis/loops/loop_candidate.h"
#include "covis/loops/loop_report.h"
#include "covis/map/shared_map.h"
#include "covis/matching/point_fuser.h"
#include "covis/optimization/pose_graph.h"

namespace covis {

// A key frame as another, of the same submap, would have it.
struct LoopTie {
  KeyFrameId current, place;
  Sim3 S_cw;
};

// The essential graph of the current key frame's submap as a problem: edges as they were before the loop, and those
// that the loop brings.
class LoopGraph {
 public:
  // A submap as the map has it, and many ties at once.
  LoopGraph(const Map& map, uint32_t submap, const std::vector<LoopTie>& ties, Sensor sensor);
  // The key frames beside the current one start where the loop has them. The submap's root stays. Motions across links
  // of fewer than `weak_link` points are hardly known: they bend first.
  LoopGraph(const Map& map, KeyFrameId current, const Loop& loop, Sensor sensor, int weak_link = 0);

  // Brings the key frames that start elsewhere, and the points that refer to them, to where they start.
  void move_beside_loop(SharedMap& map) const;
  // Ties these to every key frame that they share points with now and did not before: as they lie to each other.
  // Returns the number of edges.
  int tie(const Map& map);
  // False when it could not be solved; then the loop bends its end alone.
  bool solve();
  // The greatest distance by which the solution moves a key frame, in the map's unit.
  double greatest_move() const;
  // Writes the poses, and the points, which go with their reference key frames.
  void write_back(SharedMap& map) const;

  const PoseGraphProblem& problem() const { return problem_; }
  const std::vector<KeyFrameId>& frames() const { return frames_; }

 private:
  // The poses of a submap, those of its root fixed, and no edges.
  void take_poses(const Map& map, uint32_t submap);
  int32_t index_of(KeyFrameId id) const { return id.slot < index_.size() ? index_[id.slot] : -1; }
  Sim3 motion(const std::vector<Sim3>& poses, int32_t i, int32_t j) const;

  PoseGraphProblem problem_;
  std::vector<KeyFrameId> frames_;  // for each pose
  std::vector<int32_t> index_;      // for each slot the pose of its key frame; -1: of another submap
  std::vector<Sim3> start_;         // S_cw of each, as the map has it once move_beside_loop() is done
  std::vector<int32_t> moved_;      // those that start beside the loop, rising
  // Pairs (one that is moved, another) that shared enough points before, sorted.
  std::vector<std::pair<int32_t, int32_t>> tied_;
};

// The results of closing a loop.
struct LoopCorrection {
  int fused = 0;      // points fused and observations added
  int new_edges = 0;  // edges of the pose graph made by fused points
  double pose_graph_ms = 0;
};

// Bends the map. First the key frames beside the current one are brought to where the loop has them, and the points of
// both places are fused, so that the graph gets an edge for each pair that turns out to see the same.
LoopCorrection correct_loop(SharedMap& map, KeyFrameId current, const Loop& loop, Sensor sensor, PointFuser& fuser,
                            int weak_link = 0);

// Moves one of the two submaps of a loop to the world of the other, `kept`, and returns it; nothing when the map
// refused.
std::optional<JoinedSubmap> join_at_loop(SharedMap& map, KeyFrameId current, const Loop& loop, uint32_t kept);
// The same; the older one is kept.
std::optional<JoinedSubmap> join_at_loop(SharedMap& map, KeyFrameId current, const Loop& loop);

// Fuses the place's points with those of the current key frame and of those beside it. Returns the number of points
// fused or observations added.
int fuse_loop(SharedMap& map, KeyFrameId current, const Loop& loop, PointFuser& fuser);

// Its two steps: what the loop's matches say is the same, and the place's points wherever else they are found among
// `targets`. The second leaves what is derived from the points' observations as it is, so that several loops share one
// refresh_points_of() the targets.
int fuse_matches(SharedMap& map, KeyFrameId current, const std::vector<std::pair<uint32_t, MapPointId>>& matches);
int fuse_around(SharedMap& map, const std::vector<KeyFrameId>& targets, const LoopPlace& place, PointFuser& fuser,
                FuseMemory* memory = nullptr);
// The current key frame and its neighbours, without those of the place.
std::vector<KeyFrameId> beside(const Map& map, KeyFrameId current, const LoopPlace& place);

}  // namespace covis
