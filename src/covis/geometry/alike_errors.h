// SPDX-License-Identifier: Apache-2.0
// How far an estimate by least squares scatters when the errors of each part of what was measured are alike: a sandwich
// of the parts' gradients. Source: White, "Maximum likelihood estimation of misspecified models", Econometrica 1982.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace covis {

// The covariance of an estimate. inverse: that of the normal matrix; parts: each part's gradient at the estimate.
template <class Matrix, class Vector>
Matrix covariance_of_parts(const Matrix& inverse, const std::vector<Vector>& parts) {
  Matrix scatter = Matrix::Zero();
  for (const Vector& part : parts) scatter += part * part.transpose();
  const auto n = static_cast<double>(parts.size());
  return inverse * scatter * inverse * (n / (n - 1));
}

// Pieces of a map are poses that follow one another. As many are asked, and those that scatter most count.
inline constexpr std::array<size_t, 3> kNumbersOfPieces{4, 8, 16};

// The gradients of so many pieces, from those of the poses.
template <class Vector>
std::vector<Vector> sums_over_pieces(const std::vector<Vector>& poses, size_t pieces) {
  std::vector<Vector> sums(pieces, Vector::Zero());
  for (size_t piece = 0; piece < pieces; ++piece)
    for (size_t k = piece * poses.size() / pieces; k < (piece + 1) * poses.size() / pieces; ++k)
      sums[piece] += poses[k];
  return sums;
}

}  // namespace covis
