// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/depth_against_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "covis/core/quantile.h"
#include "covis/features/depth_lookup.h"
#include "covis/geometry/pnp.h"
#include "covis/geometry/two_view.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

constexpr double kLeastParallax = 8;  // sigmas of a keypoint: a triangulated depth is then known to about 10 %
constexpr size_t kLeastDepths = 30;
constexpr double kPrecision = 0.5;            // variance of a matched keypoint, by that of its scale
constexpr int kAttempts = 10, kAnswers = 10;  // comparisons, and answers of them, until views are passed over
constexpr int kPassedOver = 4;                // views after each that is compared then

// The distance between a point's place in the second view and that of the same direction infinitely far away, in sigmas
// of a keypoint.
double parallax(const Eigen::Vector3d& p_1, const SE3& T_21, const Pinhole& camera, double sigma) {
  const Eigen::Vector3d turned = T_21.R() * p_1, in_2 = T_21 * p_1;
  if (!(turned.z() > 0) || !(in_2.z() > 0)) return 0;
  return (camera.project(in_2) - camera.project(turned)).norm() / sigma;
}

double spread_of(std::vector<double> logarithms) {
  const double middle = quantile(logarithms, 0.5);
  for (double& value : logarithms) value = std::abs(value - middle);
  return quantile(std::move(logarithms), 0.5);
}

// The share of the matches for which a motion explains the second view by the depths measured in the first.
double explained_share(const PnpProblem& problem, const Pinhole& camera, uint64_t seed) {
  if (problem.rays.empty()) return 0;
  const auto pose = ransac_pnp(problem, camera, seed);
  return pose ? static_cast<double>(pose->inliers) / static_cast<double>(problem.rays.size()) : 0;
}

}  // namespace

std::optional<DepthAgainstMotion> compare_depth_with_motion(const Features& a, const Features& b, const Pinhole& camera,
                                                            uint64_t seed) {
  const std::vector<FeatureMatch> matches = match_descriptors(a, {}, b, {}, {});
  TwoViewMatches pairs;
  for (const FeatureMatch& m : matches) {
    const auto i = static_cast<size_t>(m.a), k = static_cast<size_t>(m.b);
    pairs.a.emplace_back(a.x[i], a.y[i]);
    pairs.b.emplace_back(b.x[k], b.y[k]);
    pairs.sigma2.push_back(std::max(a.pyramid->sigma2[a.level[i]], b.pyramid->sigma2[b.level[k]]));
  }
  // The demands of a monocular map's start: a motion that is wrong would make right depth look wrong.
  TwoViewOptions options;
  options.seed = seed;
  options.plane_parallax = std::numeric_limits<double>::infinity();
  const TwoViewResult views = reconstruct_two_views(pairs, camera, options);
  if (views.status != TwoViewStatus::ok) return std::nullopt;
  const TwoViewMotion& motion = views.motions.front();
  std::vector<double> ratios, depths;  // logarithms
  PnpProblem problem;
  const auto compare = [&](float measured, double triangulated) {
    if (!is_depth(measured) || !is_precise_depth(static_cast<double>(measured), camera)) return;
    ratios.push_back(std::log(static_cast<double>(measured) / triangulated));
    depths.push_back(std::log(triangulated));
  };
  for (size_t m = 0; m < matches.size(); ++m) {
    if (!motion.triangulated[m]) continue;
    const Eigen::Vector3d& p_1 = motion.points_1[m];
    if (parallax(p_1, motion.T_21, camera, std::sqrt(pairs.sigma2[m])) < kLeastParallax) continue;
    const auto i = static_cast<uint32_t>(matches[m].a);
    compare(a.depth[i], p_1.z());
    if (a.has_depth(matches[m].a) && is_precise_depth(static_cast<double>(a.depth[i]), camera)) {
      problem.add(unproject_depth(camera, a, i), camera.unproject(pairs.b[m].x(), pairs.b[m].y()),
                  kPrecision * pairs.sigma2[m]);
    }
    compare(b.depth[static_cast<size_t>(matches[m].b)], (motion.T_21 * p_1).z());
  }
  if (ratios.size() < kLeastDepths) return std::nullopt;
  const int points = static_cast<int>(ratios.size());
  return DepthAgainstMotion{points, spread_of(std::move(ratios)), spread_of(std::move(depths)),
                            explained_share(problem, camera, seed)};
}

// Attempts count besides answers, or a camera that hardly moves would be compared with itself for ever.
bool MotionDepthCheck::passes_over() const {
  return (answers_ >= kAnswers || attempts_ >= kAttempts) && passed_over_ < kPassedOver;
}

std::vector<DepthAgainstMotion> MotionDepthCheck::add(std::shared_ptr<const Features> view, const Pinhole& camera,
                                                      Pace pace) {
  constexpr int kPatience = 4;  // views
  std::vector<DepthAgainstMotion> answers;
  if (!last_) {
    last_ = std::move(view);
    return answers;
  }
  if (pace == Pace::usual && passes_over()) {
    if (++passed_over_ == kPassedOver) step(std::move(view));
    return answers;
  }
  const auto compare = [&](const Features& earlier) {
    const auto seed = static_cast<uint64_t>(answers_);
    const auto answer = compare_depth_with_motion(earlier, *view, camera, seed);
    if (!answer) return;
    ++answers_;
    answers.push_back(*answer);
  };
  ++attempts_;
  passed_over_ = 0;
  compare(*last_);
  if (!answers.empty() && before_last_) compare(*before_last_);
  if (!answers.empty() || ++waited_ >= kPatience) step(std::move(view));
  return answers;
}

void MotionDepthCheck::step(std::shared_ptr<const Features> view) {
  before_last_ = std::exchange(last_, std::move(view));
  waited_ = 0;
}

}  // namespace covis
