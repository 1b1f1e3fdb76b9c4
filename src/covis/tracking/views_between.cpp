// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/views_between.h"

#include <algorithm>
#include <utility>

#include "covis/optimization/pose_optimization.h"

namespace covis {
namespace {

// Sum of squared distances in sigmas, each at most this: chance matches say little.
constexpr double kMostChi2 = kChi2Mono;

struct Misfit {
  double sum = 0;
  int count = 0;
  double mean() const { return sum / std::max(count, 1); }
};

// How badly a camera that may be anywhere sees these points.
double misfit(const SE3& start_cw, const PoseObservations& seen, const Pinhole& camera) {
  std::vector<uint8_t> inlier;
  const SE3 T_cw = optimize_pose(start_cw, seen, camera, {}, inlier).T_cw;
  double sum = 0;
  for (size_t i = 0; i < seen.u.size(); ++i) {
    const Eigen::Vector3d p = T_cw * Eigen::Vector3d(seen.px[i], seen.py[i], seen.pz[i]);
    const Eigen::Vector2d off = camera.project(p) - Eigen::Vector2d(seen.u[i], seen.v[i]);
    const double chi2 = off.squaredNorm() * static_cast<double>(seen.inv_sigma2[i]);
    sum += p.z() > kMinDepth ? std::min(chi2, kMostChi2) : kMostChi2;
  }
  return sum;
}

}  // namespace

void ViewsBetween::restart(Timestamp first) {
  first_ = first;
  views_.clear();
  every_ = 1;
  passed_over_ = 0;
}

void ViewsBetween::add(Timestamp stamp, std::vector<Sighting> seen) {
  constexpr size_t kMost = 8;
  if (++passed_over_ < every_) return;
  passed_over_ = 0;
  views_.push_back({stamp, std::move(seen)});
  if (views_.size() < kMost) return;
  for (size_t k = 0; 2 * k + 1 < views_.size(); ++k) views_[k] = std::move(views_[2 * k + 1]);
  views_.resize(views_.size() / 2);
  every_ *= 2;
}

const TwoViewMotion* ViewsBetween::choose(std::span<const TwoViewMotion> motions, std::span<const uint32_t> feature,
                                          const Pinhole& camera, Timestamp second) const {
  constexpr size_t kFewest = 20;                     // points of a view
  constexpr double kClearly = 1.5, kLeastMore = 50;  // times as great, and greater by so many squared sigmas in all
  constexpr double kGood = 1;                        // the mean of a right motion is 0.2 to 0.5
  // Points that all motions have: the same measurements decide.
  std::vector<int32_t> match_of;
  for (size_t k = 0; k < feature.size(); ++k) {
    if (!std::ranges::all_of(motions, [k](const TwoViewMotion& motion) { return motion.triangulated[k] != 0; }))
      continue;
    match_of.resize(std::max<size_t>(match_of.size(), feature[k] + 1), -1);
    match_of[feature[k]] = static_cast<int32_t>(k);
  }
  std::vector<Misfit> misfits(motions.size());
  for (size_t m = 0; m < motions.size(); ++m) {
    for (const View& view : views_) {
      PoseObservations seen;
      for (const Sighting& s : view.seen) {
        const int32_t k = s.feature < match_of.size() ? match_of[s.feature] : -1;
        if (k >= 0) seen.add(motions[m].points_1[static_cast<size_t>(k)], s.u, s.v, s.inv_sigma2);
      }
      if (seen.u.size() < kFewest) continue;
      const double part = to_seconds(view.stamp - first_) / to_seconds(second - first_);
      misfits[m].sum += misfit(SE3::exp(part * motions[m].T_21.log()), seen, camera);
      misfits[m].count += seen.size();
    }
  }
  const auto best = std::ranges::min_element(misfits, {}, &Misfit::sum);
  if (best == misfits.end() || best->count == 0 || best->mean() > kGood) return nullptr;
  for (auto other = misfits.begin(); other != misfits.end(); ++other) {
    if (other != best && (other->sum < kClearly * best->sum || other->sum < best->sum + kLeastMore)) return nullptr;
  }
  return &motions[static_cast<size_t>(best - misfits.begin())];
}

}  // namespace covis
