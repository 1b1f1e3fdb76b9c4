// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/views_between.h"

#include <algorithm>
#include <utility>

#include "covis/geometry/clearly_least.h"
#include "covis/optimization/pose_optimization.h"

namespace covis {
namespace {

constexpr size_t kMostViews = 8;

// How badly the camera sees these points from its pose: squared sigmas in all, at most 5.99 a point, as chance matches
// say little.
double misfit(const SE3& T_cw, const PoseObservations& seen, const Pinhole& camera) {
  double sum = 0;
  for (size_t i = 0; i < seen.u.size(); ++i) {
    const Eigen::Vector3d p = T_cw * Eigen::Vector3d(seen.px[i], seen.py[i], seen.pz[i]);
    const Eigen::Vector2d off = camera.project(p) - Eigen::Vector2d(seen.u[i], seen.v[i]);
    const double chi2 = off.squaredNorm() * static_cast<double>(seen.inv_sigma2[i]);
    sum += p.z() > kMinDepth ? std::min(chi2, kChi2Mono) : kChi2Mono;
  }
  return sum;
}

// For each feature of the first view its match, if all motions have a point of it: the same measurements are to decide.
std::vector<int32_t> matches_of(std::span<const TwoViewMotion> motions, std::span<const uint32_t> feature) {
  std::vector<int32_t> match_of;
  for (size_t k = 0; k < feature.size(); ++k) {
    if (!std::ranges::all_of(motions, [k](const TwoViewMotion& motion) { return motion.triangulated[k] != 0; }))
      continue;
    match_of.resize(std::max<size_t>(match_of.size(), feature[k] + 1), -1);
    match_of[feature[k]] = static_cast<int32_t>(k);
  }
  return match_of;
}

}  // namespace

void ViewsBetween::restart(Timestamp first) {
  first_ = first;
  views_.clear();
  every_ = 1;
  passed_over_ = 0;
}

bool ViewsBetween::is_next_due() {
  if (++passed_over_ < every_) return false;
  passed_over_ = 0;
  return true;
}

void ViewsBetween::add(Timestamp stamp, std::vector<Sighting> seen) {
  views_.push_back({stamp, std::move(seen)});
  if (views_.size() < kMostViews) return;
  for (size_t k = 0; 2 * k + 1 < views_.size(); ++k) views_[k] = std::move(views_[2 * k + 1]);
  views_.resize(views_.size() / 2);
  every_ *= 2;
}

const TwoViewMotion* ViewsBetween::choose(std::span<const TwoViewMotion> motions, std::span<const uint32_t> feature,
                                          const Pinhole& camera, Timestamp second) const {
  constexpr int kFewest = 20;                        // points of a view
  constexpr double kClearly = 1.5, kLeastMore = 50;  // squared sigmas in all
  constexpr double kGood = 1;                        // squared sigmas a point; a right motion has 0.2 to 0.5
  const std::vector<int32_t> match_of = matches_of(motions, feature);
  std::vector<double> misfits(motions.size()), of_view(motions.size());
  int count = 0;
  PoseObservations seen;
  std::vector<uint8_t> inlier;
  for (const View& view : views_) {
    const double part = to_seconds(view.stamp - first_) / to_seconds(second - first_);
    bool found = true;
    for (size_t m = 0; m < motions.size() && found; ++m) {
      seen.clear();
      for (const Sighting& s : view.seen) {
        const int32_t k = s.feature < match_of.size() ? match_of[s.feature] : -1;
        if (k >= 0) seen.add(motions[m].points_1[static_cast<size_t>(k)], s.u, s.v, s.inv_sigma2);
      }
      const PoseResult pose = optimize_pose(SE3::exp(part * motions[m].T_21.log()), seen, camera, {}, inlier);
      found = seen.size() >= kFewest && pose.ok;
      of_view[m] = misfit(pose.T_cw, seen, camera);
    }
    if (!found) continue;  // a search that fails is no evidence
    for (size_t m = 0; m < motions.size(); ++m) misfits[m] += of_view[m];
    count += seen.size();
  }
  const auto chosen = clearly_least(misfits, kClearly, kLeastMore);
  return chosen && misfits[*chosen] < kGood * count ? &motions[*chosen] : nullptr;
}

}  // namespace covis
