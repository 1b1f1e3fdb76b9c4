// SPDX-License-Identifier: Apache-2.0
// How far a trajectory is from the truth.
// Sources: Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012 (ATE, RPE); Geiger, Lenz,
// Urtasun, "Are we ready for autonomous driving?", CVPR 2012 (t_rel, r_rel); Zhang and Scaramuzza, "A tutorial on
// quantitative trajectory evaluation", IROS 2018 (alignment).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/geometry/alignment.h"
#include "covis/io/trajectory.h"

namespace covis {

// How the estimate is put onto the truth: by all positions, rigidly or with scale; not at all; by the first compared
// pose alone, to tell how far it strays from there, rigidly or with the scale of sim3.
enum class AlignMode { se3, sim3, none, first, first_sim3 };
enum class DeltaUnit { frames, seconds, metres };

struct EvaluationOptions {
  AlignMode align = AlignMode::se3;
  double max_difference = 0.02;  // seconds between a pose and the truth it is compared with
  double max_gap = 0.1;          // seconds between two true poses that may be interpolated between
  double delta = 1;              // step of the relative pose error
  DeltaUnit delta_unit = DeltaUnit::frames;
};

struct ErrorStatistics {
  double rmse = 0, mean = 0, median = 0, max = 0;
};

// One pose beside its truth, both in the truth's world.
struct ComparedPose {
  Timestamp stamp = 0;
  SE3 estimate, truth;  // T_wc; the estimate aligned
  double error = 0;     // metres between both
};

struct KittiError {
  double t_rel_percent = 0;     // translation error over segment length
  double r_rel_deg_100m = 0;    // rotation error
  std::vector<double> lengths;  // metres, of the segments used
  bool standard = false;        // lengths are the benchmark's 100 … 800 m
};

struct Evaluation {
  size_t poses = 0;       // in the estimate
  size_t associated = 0;  // those with truth
  size_t truth_poses = 0;
  double coverage = 0;               // share of the true poses that an estimate was associated with
  double scale = 1;                  // the estimate times this fits the truth (sim3)
  bool unique_alignment = true;      // false: a straight path; the rotation about it is arbitrary
  ErrorStatistics ate;               // metres
  ErrorStatistics rotation_deg;      // after alignment
  ErrorStatistics rpe_translation;   // metres over delta
  ErrorStatistics rpe_rotation_deg;  // over delta
  size_t rpe_pairs = 0;
  double path_length = 0;           // metres of the truth along the associated poses
  double drift_percent = 0;         // ATE RMSE over path length
  std::optional<KittiError> kitti;  // empty when the path is too short
  std::vector<ComparedPose> compared;
};

// Errors: fewer than 3 poses with truth (both time spans are named).
Result<Evaluation> evaluate(const Trajectory& estimate, const Trajectory& truth, const EvaluationOptions& options);

nlohmann::json to_json(const Evaluation& evaluation);
// A table for people.
std::string to_text(const Evaluation& evaluation);

}  // namespace covis
