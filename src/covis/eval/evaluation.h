// SPDX-License-Identifier: Apache-2.0
// The deviation of a trajectory from the ground truth.
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

// Alignment of the estimate to the ground truth: by all positions, rigidly or with scale; none; or by the first
// compared pose alone, rigidly or with the scale of sim3, which shows how far the estimate drifts from there.
enum class AlignMode { se3, sim3, none, first, first_sim3 };
enum class DeltaUnit { frames, seconds, metres };

struct EvaluationOptions {
  AlignMode align = AlignMode::se3;
  double max_difference = 0.02;  // greatest time between a pose and the ground truth it is compared with, seconds
  double max_gap = 0.1;          // greatest time between two true poses for interpolation, seconds
  double delta = 1;              // step of the relative pose error
  DeltaUnit delta_unit = DeltaUnit::frames;
};

struct ErrorStatistics {
  double rmse = 0, mean = 0, median = 0, max = 0;
};

// One pose and its ground truth, both in the world of the ground truth.
struct ComparedPose {
  Timestamp stamp = 0;
  SE3 estimate, truth;  // T_wc; the estimate is aligned
  double error = 0;     // distance between the two positions, metres
};

struct KittiError {
  double t_rel_percent = 0;     // translation error relative to the segment length
  double r_rel_deg_100m = 0;    // rotation error
  std::vector<double> lengths;  // lengths of the segments used, metres
  bool standard = false;        // true: lengths are the benchmark's 100 … 800 m
};

struct Evaluation {
  size_t poses = 0;       // number of poses of the estimate
  size_t associated = 0;  // number of those that have ground truth
  size_t truth_poses = 0;
  double coverage = 0;               // share of the true poses that have an associated estimate
  double scale = 1;                  // factor that fits the estimate to the ground truth (sim3)
  bool unique_alignment = true;      // false: the path is straight, and the rotation about it is arbitrary
  ErrorStatistics ate;               // metres
  ErrorStatistics rotation_deg;      // error after alignment
  ErrorStatistics rpe_translation;   // metres over delta
  ErrorStatistics rpe_rotation_deg;  // degrees over delta
  size_t rpe_pairs = 0;              // number of pairs of poses a step apart; 0: there is no relative error
  double path_length = 0;            // length of the ground truth along the associated poses, metres
  double drift_percent = 0;          // ATE RMSE relative to the path length
  std::optional<KittiError> kitti;   // nullopt when the path is too short
  std::vector<ComparedPose> compared;
};

// Fails for fewer than 3 poses with ground truth; the error names both time spans.
Result<Evaluation> evaluate(const Trajectory& estimate, const Trajectory& truth, const EvaluationOptions& options);

nlohmann::json to_json(const Evaluation& evaluation);
// Returns a table for people to read.
std::string to_text(const Evaluation& evaluation);

}  // namespace covis
