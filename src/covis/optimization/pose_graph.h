// SPDX-License-Identifier: Apache-2.0
// Pose graph over Sim(3): moves cameras so that measured motions between pairs of them agree, which spreads the drift
// of a loop (in scale too) over its cameras. Plain problem in, plain result out; knows no map. Source: Strasdat,
// Montiel, Davison, "Scale drift-aware large scale monocular SLAM", RSS 2010, section IV; Jacobians: Solà, Deray,
// Atchuthan, "A micro Lie theory", 2018, section II-G. Damping: Nielsen, 1999, as in bundle adjustment. The cost is sum
// |e|^2,  e = log(S_ji * S_i * S_j^-1), 7 rows of equal weight: [rho; phi; sigma].
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "covis/geometry/sim3.h"

namespace covis {

struct PoseGraphEdge {
  int32_t i = 0, j = 0;  // indices into poses, different
  Sim3 S_ji;             // measured: from camera i's coordinates to camera j's
};

struct PoseGraphProblem {
  std::vector<Sim3> poses;     // S_cw, world to camera
  std::vector<uint8_t> fixed;  // for each pose: 1 does not move. One at least should be: nothing else holds the whole
  std::vector<PoseGraphEdge> edges;
  bool fix_scale = false;  // 6 rows and 6 unknowns, no sigma: stereo and RGB-D. The scales given (1) stay
};

struct PoseGraphOptions {
  int iterations = 20;                           // accepted or rejected Levenberg-Marquardt steps, at most
  double relative_cost_change = 1e-6;            // stop when a step gains less
  const std::atomic<bool>* interrupt = nullptr;  // when it becomes true the last accepted state is returned soon
};

struct PoseGraphSummary {
  double initial_cost = 0, final_cost = 0;
  int iterations = 0;
  bool interrupted = false;
  bool ok = true;  // false: no edge has a pose that moves, values that are not finite, or no step could be made
};

PoseGraphSummary optimize_pose_graph(PoseGraphProblem& problem, const PoseGraphOptions& options = {});

// The residual of an edge, and its Jacobians by left perturbations of the two poses: S_i <- exp(d_i) S_i, the same of
// j.
Vector7d pose_graph_residual(const Sim3& S_ji, const Sim3& S_iw, const Sim3& S_jw);
Vector7d pose_graph_residual(const Sim3& S_ji, const Sim3& S_iw, const Sim3& S_jw, Matrix7d& J_i, Matrix7d& J_j);

}  // namespace covis
