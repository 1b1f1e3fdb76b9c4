// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/epipolar_match.h"

#include <cmath>
#include <optional>

#include "covis/matching/near_line.h"

namespace covis {
namespace {

// F with x_b' F x_a = 0 for homogeneous pixels.
Eigen::Matrix3d fundamental(const Pinhole& c, const SE3& T_ba) {
  Eigen::Matrix3d inverse_k;
  inverse_k << 1 / c.fx, 0, -c.cx / c.fx, 0, 1 / c.fy, -c.cy / c.fy, 0, 0, 1;
  return inverse_k.transpose() * hat(T_ba.t()) * T_ba.R() * inverse_k;
}

}  // namespace

std::vector<FeatureMatch> match_epipolar(const Pinhole& camera, const Features& a, std::span<const uint8_t> use_a,
                                         const Features& b, std::span<const uint8_t> use_b, const SE3& T_ba,
                                         const EpipolarMatchOptions& options) {
  std::vector<int32_t> to;  // features of b
  for (int32_t j = 0; j < b.size(); ++j) {
    if (use_b.empty() || use_b[static_cast<size_t>(j)]) to.push_back(j);
  }
  const size_t n = to.size();
  const Eigen::Matrix3d F = fundamental(camera, T_ba);
  std::optional<Eigen::Vector2d> epipole;
  if (T_ba.t().z() != 0) epipole = camera.project(T_ba.t());

  // The line first: it rejects most, and costs less than comparing descriptors.
  LinePoints points(n);
  for (size_t j = 0; j < n; ++j) {
    const auto jb = static_cast<size_t>(to[j]);
    points.set(j, b.x[jb], b.y[jb], static_cast<float>(options.max_chi2) * b.pyramid->sigma2[b.level[jb]]);
  }
  const auto near_epipole = [&](size_t ia, size_t jb) {
    if (!epipole || a.depth[ia] > 0 || b.depth[jb] > 0) return false;
    const double margin = options.epipole_margin * b.pyramid->scale[b.level[jb]];
    return (Eigen::Vector2d(b.x[jb], b.y[jb]) - *epipole).squaredNorm() < margin * margin;
  };

  struct Owner {
    int32_t a = -1;
    int distance = kHammingBeyond;
  };
  std::vector<Owner> owner(n);
  std::vector<uint32_t> on_line(n);
  std::vector<int> distance(n);  // of the features on the line
  for (int32_t i = 0; i < a.size(); ++i) {
    const auto ia = static_cast<size_t>(i);
    if (!use_a.empty() && !use_a[ia]) continue;
    const Eigen::Vector3d line = F * Eigen::Vector3d(a.x[ia], a.y[ia], 1);
    const double norm = line.head<2>().norm();
    if (!(norm > 0)) continue;
    const Eigen::Vector3f l = (line / norm).cast<float>();
    const size_t near = near_line({l.x(), l.y(), l.z()}, points, on_line.data());
    int best = options.max_distance + 1;
    size_t best_j = 0;
    for (size_t k = 0; k < near; ++k) {
      const size_t j = on_line[k];
      const auto jb = static_cast<size_t>(to[j]);
      distance[k] = hamming(a.descriptor[ia], b.descriptor[jb]);
      if (distance[k] >= best || near_epipole(ia, jb)) continue;
      best = distance[k];
      best_j = j;
    }
    if (best > options.max_distance || best >= owner[best_j].distance) continue;
    const auto jb = static_cast<size_t>(to[best_j]);
    const float margin = static_cast<float>(options.rival_margin) * b.pyramid->scale[b.level[jb]];
    const auto is_rival = [&](size_t k) {
      const auto other = static_cast<size_t>(to[on_line[k]]);
      return best >= options.max_ratio * distance[k] && std::hypot(b.x[other] - b.x[jb], b.y[other] - b.y[jb]) > margin;
    };
    bool unique = true;
    for (size_t k = 0; options.max_ratio < 1 && unique && k < near; ++k) unique = !is_rival(k);
    if (unique) owner[best_j] = {i, best};
  }

  std::vector<int32_t> match_of(static_cast<size_t>(a.size()), -1);
  for (size_t j = 0; j < n; ++j) {
    if (owner[j].a >= 0) match_of[static_cast<size_t>(owner[j].a)] = to[j];
  }
  std::vector<FeatureMatch> matches;
  for (int32_t i = 0; i < a.size(); ++i) {
    if (match_of[static_cast<size_t>(i)] >= 0) matches.push_back({i, match_of[static_cast<size_t>(i)]});
  }
  keep_consistent_rotations(a, b, matches);
  return matches;
}

}  // namespace covis
