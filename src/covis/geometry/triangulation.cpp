// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/triangulation.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace covis {

std::optional<Eigen::Vector3d> triangulate(const SE3& T_1w, const Eigen::Vector3d& ray_1, const SE3& T_2w,
                                           const Eigen::Vector3d& ray_2) {
  Eigen::Matrix4d A;
  const auto rows = [&](int at, const SE3& T, const Eigen::Vector3d& ray) {
    Eigen::Matrix<double, 3, 4> P;
    P << T.R(), T.t();
    A.row(at) = ray.x() * P.row(2) - P.row(0);
    A.row(at + 1) = ray.y() * P.row(2) - P.row(1);
  };
  rows(0, T_1w, ray_1);
  rows(2, T_2w, ray_2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(A.transpose() * A);
  const Eigen::Vector4d p = solver.eigenvectors().col(0);
  if (std::abs(p.w()) < 1e-12) return std::nullopt;
  return Eigen::Vector3d(p.head<3>() / p.w());
}

}  // namespace covis
