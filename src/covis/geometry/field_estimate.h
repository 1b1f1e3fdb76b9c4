// SPDX-License-Identifier: Apache-2.0
// The estimate of a ShiftField from normal equations.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "covis/geometry/shift_field.h"

namespace covis {

struct FieldEstimate {
  static constexpr int kTerms = static_cast<int>(ShiftField::kTerms);
  using Vector = Eigen::Matrix<double, kTerms, 1>;
  using Matrix = Eigen::Matrix<double, kTerms, kTerms>;

  Matrix H = Matrix::Zero();  // H field = b
  Vector b = Vector::Zero();
  ShiftField field;

  static Vector vector(const ShiftField::Terms& terms) { return Eigen::Map<const Vector>(terms.data()); }
  void add(const Vector& terms, double pixels, double weight) {
    H += weight * terms * terms.transpose();
    b += weight * pixels * terms;
  }
  // False: they do not tell it.
  bool solve() {
    const Eigen::LDLT<Matrix> ldlt(H);
    const Vector solution = ldlt.solve(b);
    if (ldlt.info() != Eigen::Success || !ldlt.isPositive() || !solution.allFinite()) return false;
    Eigen::Map<Vector>(field.pixels.data()) = solution;
    return true;
  }
  Matrix inverse() const { return H.ldlt().solve(Matrix::Identity()); }
  // Root mean square over places with this mean of terms * terms^T, pixels.
  double size(const Matrix& places) const {
    const Vector f = vector(field.pixels);
    return std::sqrt(f.dot(places * f));
  }
};

}  // namespace covis
