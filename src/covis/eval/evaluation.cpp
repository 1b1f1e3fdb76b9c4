// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

namespace covis {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

double angle_deg(const SE3& T) { return so3_log(T.R()).norm() * kDegrees; }

ErrorStatistics statistics(std::vector<double> values) {
  ErrorStatistics s;
  if (values.empty()) return s;
  std::sort(values.begin(), values.end());
  double sum = 0, squares = 0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
  }
  const auto n = static_cast<double>(values.size());
  s.rmse = std::sqrt(squares / n);
  s.mean = sum / n;
  const size_t half = values.size() / 2;
  s.median = values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
  s.max = values.back();
  return s;
}

Trajectory sorted(Trajectory trajectory) {
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  const auto last = std::unique(trajectory.begin(), trajectory.end(),
                                [](const StampedPose& a, const StampedPose& b) { return a.stamp == b.stamp; });
  trajectory.erase(last, trajectory.end());
  return trajectory;
}

// The ground truth at a stamp: the true pose itself when one is within half a millisecond, else interpolated between
// two poses, else the nearest one if it is near enough.
std::optional<SE3> truth_at(const Trajectory& truth, Timestamp stamp, const EvaluationOptions& options,
                            size_t& nearest) {
  const auto next = std::lower_bound(truth.begin(), truth.end(), stamp,
                                     [](const StampedPose& p, Timestamp t) { return p.stamp < t; });
  const auto distance = [&](Trajectory::const_iterator p) { return std::abs(p->stamp - stamp); };
  Trajectory::const_iterator best = next;
  if (next == truth.end() || (next != truth.begin() && distance(next - 1) < distance(next))) best = next - 1;
  nearest = static_cast<size_t>(best - truth.begin());
  constexpr Timestamp kSame = 500'000;  // ns: stamps rounded to milliseconds count as equal
  if (distance(best) <= kSame) return best->T_wc;
  if (next != truth.begin() && next != truth.end()) {
    const StampedPose &a = *(next - 1), &b = *next;
    const Timestamp gap = b.stamp - a.stamp;
    if (to_seconds(gap) <= options.max_gap) {
      const double s = static_cast<double>(stamp - a.stamp) / static_cast<double>(gap);
      return SE3(a.T_wc.q().slerp(s, b.T_wc.q()), Eigen::Vector3d((1 - s) * a.T_wc.t() + s * b.T_wc.t()));
    }
  }
  if (to_seconds(distance(best)) <= options.max_difference) return best->T_wc;
  return std::nullopt;
}

std::string span_text(const Trajectory& t) {
  if (t.empty()) return "no poses";
  char text[96];
  std::snprintf(text, sizeof text, "%zu poses from %.3f to %.3f s", t.size(), to_seconds(t.front().stamp),
                to_seconds(t.back().stamp));
  return text;
}

// Returns the distance travelled up to each pose.
std::vector<double> travelled(const std::vector<ComparedPose>& poses) {
  std::vector<double> distance{0};
  for (size_t i = 1; i < poses.size(); ++i) {
    distance.push_back(distance.back() + (poses[i].truth.t() - poses[i - 1].truth.t()).norm());
  }
  return distance;
}

void relative_errors(const std::vector<ComparedPose>& poses, const std::vector<double>& distance,
                     const EvaluationOptions& options, Evaluation& result) {
  std::vector<double> translation, rotation;
  size_t j = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    const auto reached = [&](size_t k) {
      switch (options.delta_unit) {
        case DeltaUnit::frames:
          return static_cast<double>(k - i) >= options.delta;
        case DeltaUnit::seconds:
          return to_seconds(poses[k].stamp - poses[i].stamp) >= options.delta - 1e-9;
        case DeltaUnit::metres:
          return distance[k] - distance[i] >= options.delta - 1e-9;
      }
      return false;
    };
    j = std::max(j, i + 1);
    while (j < poses.size() && !reached(j)) ++j;
    if (j >= poses.size()) break;
    const SE3 error =
        (poses[i].truth.inverse() * poses[j].truth).inverse() * (poses[i].estimate.inverse() * poses[j].estimate);
    translation.push_back(error.t().norm());
    rotation.push_back(angle_deg(error));
  }
  result.rpe_pairs = translation.size();
  result.rpe_translation = statistics(translation);
  result.rpe_rotation_deg = statistics(rotation);
}

// The benchmark's definition: from every 10th pose, segments of 100 … 800 m. A shorter path uses eighths of its length,
// and the result says so.
std::optional<KittiError> kitti_error(const std::vector<ComparedPose>& poses, const std::vector<double>& distance) {
  KittiError result;
  const double path = distance.back();
  result.standard = path >= 100;
  for (int k = 1; k <= 8; ++k) {
    const double length = result.standard ? 100.0 * k : path * k / 10;
    if (length <= path) result.lengths.push_back(length);
  }
  if (!(path > 1e-6)) return std::nullopt;
  const size_t step = result.standard ? 10 : 1;
  double translation = 0, rotation = 0;
  size_t count = 0;
  for (const double length : result.lengths) {
    for (size_t i = 0; i < poses.size(); i += step) {
      const auto end =
          std::lower_bound(distance.begin() + static_cast<ptrdiff_t>(i), distance.end(), distance[i] + length);
      if (end == distance.end()) break;
      const auto j = static_cast<size_t>(end - distance.begin());
      const SE3 error =
          (poses[i].estimate.inverse() * poses[j].estimate).inverse() * (poses[i].truth.inverse() * poses[j].truth);
      translation += error.t().norm() / length;
      rotation += angle_deg(error) / length;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  result.t_rel_percent = 100 * translation / static_cast<double>(count);
  result.r_rel_deg_100m = 100 * rotation / static_cast<double>(count);
  return result;
}

// The alignment that maps this pose to its ground truth.
Alignment by_pose(const ComparedPose& pose, double scale) {
  const Eigen::Matrix3d R = pose.truth.R() * pose.estimate.R().transpose();
  return {.T_ba = SE3(R, Eigen::Vector3d(pose.truth.t() - scale * (R * pose.estimate.t()))), .scale = scale};
}

}  // namespace

Result<Evaluation> evaluate(const Trajectory& estimate_in, const Trajectory& truth_in,
                            const EvaluationOptions& options) {
  const Trajectory estimate = sorted(estimate_in), truth = sorted(truth_in);
  Evaluation result;
  result.poses = estimate.size();
  result.truth_poses = truth.size();
  std::set<size_t> covered;
  std::vector<Eigen::Vector3d> from, to;
  if (!truth.empty()) {
    for (const StampedPose& pose : estimate) {
      size_t nearest = 0;
      const auto at = truth_at(truth, pose.stamp, options, nearest);
      if (!at) continue;
      covered.insert(nearest);
      result.compared.push_back({pose.stamp, pose.T_wc, *at, 0});
      from.push_back(pose.T_wc.t());
      to.push_back(at->t());
    }
  }
  result.associated = result.compared.size();
  if (result.associated < 3) {
    return fail("only " + std::to_string(result.associated) +
                " poses have ground truth at their time; at least 3 are needed. The trajectory: " +
                span_text(estimate) + "; the truth: " + span_text(truth));
  }
  result.coverage = static_cast<double>(covered.size()) / static_cast<double>(truth.size());
  const AlignMode mode = options.align;
  Alignment alignment;
  const Scale scale = mode == AlignMode::sim3 || mode == AlignMode::first_sim3 ? Scale::free : Scale::fixed;
  if (scale == Scale::free || mode == AlignMode::se3) {
    const auto found = align(from, to, scale);
    if (!found) return fail("the trajectory can't be aligned: all its positions are the same");
    if (!(found->scale > 0)) return fail("there is no scale to align with: in the truth all positions are the same");
    alignment = *found;
  }
  if (mode == AlignMode::first || mode == AlignMode::first_sim3)
    alignment = by_pose(result.compared.front(), alignment.scale);
  result.scale = alignment.scale;
  result.unique_alignment = alignment.unique;
  std::vector<double> errors, rotations;
  for (ComparedPose& pose : result.compared) {
    pose.estimate = SE3(Eigen::Matrix3d(alignment.T_ba.R() * pose.estimate.R()), alignment * pose.estimate.t());
    pose.error = (pose.estimate.t() - pose.truth.t()).norm();
    errors.push_back(pose.error);
    rotations.push_back(angle_deg(pose.truth.inverse() * pose.estimate));
  }
  result.ate = statistics(errors);
  result.rotation_deg = statistics(rotations);
  const std::vector<double> distance = travelled(result.compared);
  result.path_length = distance.back();
  if (result.path_length > 0) result.drift_percent = 100 * result.ate.rmse / result.path_length;
  relative_errors(result.compared, distance, options, result);
  result.kitti = kitti_error(result.compared, distance);
  return result;
}

nlohmann::json to_json(const Evaluation& e) {
  const auto stats = [](const ErrorStatistics& s) {
    return nlohmann::json{{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"max", s.max}};
  };
  nlohmann::json json{{"poses", e.poses},
                      {"associated", e.associated},
                      {"truth_poses", e.truth_poses},
                      {"coverage", e.coverage},
                      {"scale", e.scale},
                      {"unique_alignment", e.unique_alignment},
                      {"ate_m", stats(e.ate)},
                      {"rotation_deg", stats(e.rotation_deg)},
                      {"rpe_m", e.rpe_pairs > 0 ? stats(e.rpe_translation) : nullptr},
                      {"rpe_deg", e.rpe_pairs > 0 ? stats(e.rpe_rotation_deg) : nullptr},
                      {"rpe_pairs", e.rpe_pairs},
                      {"path_m", e.path_length},
                      {"drift_percent", e.drift_percent}};
  if (e.kitti) {
    json["kitti"] = {{"t_rel_percent", e.kitti->t_rel_percent},
                     {"r_rel_deg_100m", e.kitti->r_rel_deg_100m},
                     {"lengths_m", e.kitti->lengths},
                     {"standard_lengths", e.kitti->standard}};
  }
  return json;
}

std::string to_text(const Evaluation& e) {
  std::string text;
  char line[256];
  const auto add = [&](const char* format, auto... values) {
    std::snprintf(line, sizeof line, format, values...);
    text += line;
  };
  add("poses           %zu, of them %zu with truth (%.1f %% of %zu true poses)\n", e.poses, e.associated,
      100 * e.coverage, e.truth_poses);
  add("path            %.3f m\n", e.path_length);
  add("scale           %.5f\n", e.scale);
  add("%-15s %10s %10s %10s %10s\n", "", "RMSE", "mean", "median", "max");
  const auto row = [&](const char* name, const ErrorStatistics& s, const char* unit) {
    add("%-15s %10.5f %10.5f %10.5f %10.5f %s\n", name, s.rmse, s.mean, s.median, s.max, unit);
  };
  row("ATE", e.ate, "m");
  row("rotation", e.rotation_deg, "deg");
  if (e.rpe_pairs > 0) {
    row("RPE", e.rpe_translation, "m");
    row("RPE rotation", e.rpe_rotation_deg, "deg");
  } else {
    text += "RPE             none: no two poses are a step (--delta) apart\n";
  }
  add("drift           %.4f %% of the path\n", e.drift_percent);
  if (e.kitti) {
    add("KITTI           t_rel %.4f %%, r_rel %.4f deg/100 m, over segments of %.1f to %.1f m%s\n",
        e.kitti->t_rel_percent, e.kitti->r_rel_deg_100m, e.kitti->lengths.front(), e.kitti->lengths.back(),
        e.kitti->standard ? "" : " (the path is shorter than the benchmark's 100 m)");
  }
  if (!e.unique_alignment) text += "note: the path is a straight line; the rotation about it is arbitrary\n";
  return text;
}

}  // namespace covis
