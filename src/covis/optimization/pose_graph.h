// SPDX-License-Identifier: Apache-2.0
// Pose graph over Sim(3): moves cameras so that measured motions between pairs of them agree, which distributes the
// drift of a loop (of scale too) over its cameras. Input and output are plain data; the code does not depend on the
// map. Source: Strasdat, Montiel, Davison, "Scale drift-aware large scale monocular SLAM", RSS 2010, section IV;
// Jacobians: Solà, Deray, Atchuthan, "A micro Lie theory", 2018, section II-G. Damping: Nielsen, 1999, as in bundle
// adjustment. The cost is sum w |e|^2,  e = log(S_ji * S_i * S_j^-1), 7 rows of equal weight: [rho; phi; sigma].
#pragma once

#include <cstdint>
#include <vector>

#include "covis/geometry/sim3.h"

namespace covis {

struct PoseGraphEdge {
  int32_t i = 0, j = 0;  // two different indices into poses
  Sim3 S_ji;             // measured motion, from camera i's to camera j's coordinates
  double weight = 1;     // w: small for a motion that is hardly known
};

struct PoseGraphProblem {
  std::vector<Sim3> poses;  // S_cw, world to camera
  // One per pose; 1: the pose does not move. At least one should be fixed, to remove the gauge freedom.
  std::vector<uint8_t> fixed;
  std::vector<PoseGraphEdge> edges;
  bool fix_scale = false;  // stereo and RGB-D: 6 rows and 6 unknowns, no sigma. The given scales (1) are kept
};

struct PoseGraphOptions {
  int iterations = 20;                 // greatest number of Levenberg-Marquardt steps, accepted or rejected
  double relative_cost_change = 1e-6;  // relative decrease of the cost below which the solver stops
};

struct PoseGraphSummary {
  double initial_cost = 0, final_cost = 0;
  int iterations = 0;
  bool ok = true;  // false: no edge has a pose that moves, a value is not finite, or no step could be made
};

PoseGraphSummary optimize_pose_graph(PoseGraphProblem& problem, const PoseGraphOptions& options = {});

// The residual of an edge, and its Jacobians for left perturbations of the two poses: S_i <- exp(d_i) S_i, and likewise
// for j.
Vector7d pose_graph_residual(const Sim3& S_ji, const Sim3& S_iw, const Sim3& S_jw);
Vector7d pose_graph_residual(const Sim3& S_ji, const Sim3& S_iw, const Sim3& S_jw, Matrix7d& J_i, Matrix7d& J_j);

}  // namespace covis
