// SPDX-License-Identifier: Apache-2.0
// Closing a recognised loop: the pose graph over Sim(3), the points carried along, and both places' points fused.
// Joining two submaps that turn out to show one place.
// Sources: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, sections VII-C and VII-D; Strasdat et al., RSS 2010 (pose
// graph over Sim(3)).
#pragma once

#include <vector>

#include "covis/core/sensor.h"
#include "covis/loops/loop_verifier.h"
#include "covis/map/shared_map.h"
#include "covis/matching/point_fuser.h"
#include "covis/optimization/pose_graph.h"

namespace covis {

// The essential graph of the current key frame's submap as a problem: edges as they were before the loop, and the loop.
struct LoopGraph {
  PoseGraphProblem problem;
  std::vector<KeyFrameId> frames;  // for each pose
  std::vector<SE3> before;         // T_cw of each

  // The key frames beside the current one start where the loop has them. The submap's root stays.
  LoopGraph(const Map& map, KeyFrameId current, const Loop& loop, Sensor sensor);
};

// Bends the map. Returns the milliseconds that the pose graph took.
double correct_loop(SharedMap& map, KeyFrameId current, const Loop& loop, Sensor sensor);

// Moves the younger submap to the older one's world. Returns the number of key frames that were moved; 0 when the map
// refused.
int join_at_loop(SharedMap& map, KeyFrameId current, const Loop& loop);

// Fuses the place's points with those of the current key frame and of those beside it. Returns the number of points
// fused or observations added.
int fuse_loop(SharedMap& map, KeyFrameId current, const Loop& loop, PointFuser& fuser);

}  // namespace covis
