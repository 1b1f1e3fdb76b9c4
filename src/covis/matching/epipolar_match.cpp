// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/epipolar_match.h"

#include <cmath>
#include <optional>

#include "covis/features/hamming.h"
#include "covis/matching/descriptor_subset.h"

namespace covis {
namespace {

// F with x_b' F x_a = 0 for homogeneous pixels.
Eigen::Matrix3d fundamental(const Pinhole& a, const Pinhole& b, const SE3& T_ba) {
  const auto inverse_k = [](const Pinhole& c) {
    Eigen::Matrix3d k;
    k << 1 / c.fx, 0, -c.cx / c.fx, 0, 1 / c.fy, -c.cy / c.fy, 0, 0, 1;
    return k;
  };
  return inverse_k(b).transpose() * hat(T_ba.t()) * T_ba.R() * inverse_k(a);
}

}  // namespace

std::vector<FeatureMatch> match_epipolar(const Features& a, std::span<const uint8_t> use_a, const Features& b,
                                         std::span<const uint8_t> use_b, const SE3& T_ba,
                                         const EpipolarMatchOptions& options) {
  const DescriptorSubset to(b, use_b);
  const size_t n = to.size();
  const Eigen::Matrix3d F = fundamental(a.camera, b.camera, T_ba);
  std::optional<Eigen::Vector2d> epipole;
  if (T_ba.t().z() > 0) epipole = b.camera.project(T_ba.t());

  struct Owner {
    int32_t a = -1;
    int distance = 257;
  };
  std::vector<Owner> owner(n);
  std::vector<uint16_t> row(n);
  for (int32_t i = 0; i < a.size(); ++i) {
    const auto ia = static_cast<size_t>(i);
    if (!use_a.empty() && !use_a[ia]) continue;
    hamming_row(a.descriptor[ia], to.descriptors(), static_cast<int>(n), row.data());
    const Eigen::Vector3d line = F * Eigen::Vector3d(a.x[ia], a.y[ia], 1);
    const double norm2 = line.head<2>().squaredNorm();
    if (!(norm2 > 0)) continue;
    int best = options.max_distance + 1;
    size_t best_j = 0;
    for (size_t j = 0; j < n; ++j) {
      if (row[j] >= best) continue;
      const auto jb = static_cast<size_t>(to.feature(j));
      const double x = b.x[jb], y = b.y[jb];
      const double sigma2 = b.pyramid->sigma2[b.level[jb]];
      const double residual = line.x() * x + line.y() * y + line.z();
      if (residual * residual > options.max_chi2 * sigma2 * norm2) continue;
      if (epipole && !(a.depth[ia] > 0) && !(b.depth[jb] > 0)) {
        const double margin = options.epipole_margin * b.pyramid->scale[b.level[jb]];
        if ((Eigen::Vector2d(x, y) - *epipole).squaredNorm() < margin * margin) continue;
      }
      best = row[j];
      best_j = j;
    }
    if (best <= options.max_distance && best < owner[best_j].distance) owner[best_j] = {i, best};
  }

  std::vector<int32_t> match_of(static_cast<size_t>(a.size()), -1);
  for (size_t j = 0; j < n; ++j) {
    if (owner[j].a >= 0) match_of[static_cast<size_t>(owner[j].a)] = to.feature(j);
  }
  std::vector<FeatureMatch> matches;
  for (int32_t i = 0; i < a.size(); ++i) {
    if (match_of[static_cast<size_t>(i)] >= 0) matches.push_back({i, match_of[static_cast<size_t>(i)]});
  }
  if (options.check_rotation) keep_consistent_rotations(a, b, matches);
  return matches;
}

}  // namespace covis
