// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/alignment.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace covis {

std::optional<Alignment> align(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b, Scale scale) {
  const size_t n = a.size();
  if (n < 3 || b.size() != n) return std::nullopt;
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < n; ++i) {
    mean_a += a[i];
    mean_b += b[i];
  }
  mean_a /= static_cast<double>(n);
  mean_b /= static_cast<double>(n);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double variance_a = 0;
  for (size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d da = a[i] - mean_a;
    covariance += (b[i] - mean_b) * da.transpose();
    variance_a += da.squaredNorm();
  }
  if (!covariance.allFinite() || !(variance_a > 0)) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  Alignment result;
  const Eigen::Matrix3d R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  if (scale == Scale::free) result.scale = svd.singularValues().dot(sign) / variance_a;
  result.T_ba = SE3(R, Eigen::Vector3d(mean_b - result.scale * (R * mean_a)));
  result.unique = svd.singularValues()(1) > 1e-9 * svd.singularValues()(0);
  double sum = 0;
  for (size_t i = 0; i < n; ++i) sum += (b[i] - result * a[i]).squaredNorm();
  result.rmse = std::sqrt(sum / static_cast<double>(n));
  return result;
}

}  // namespace covis
