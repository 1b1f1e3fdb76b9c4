// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/readout_comparison.h"

#include <Eigen/Cholesky>

#include "covis/core/reserve.h"

namespace covis {

void ReadoutComparison::start(size_t most) {
  matches_.clear();
  reserve_ahead(matches_, most);
  reserve_ahead(weights_, most);
}

std::optional<ReadoutComparison::Result> ReadoutComparison::result(double present) {
  constexpr size_t kFewest = 30;
  constexpr int kRounds = 3;
  constexpr double kUsual = 0.03;  // seconds: how far two views' own readout may be from the present one
  if (matches_.size() < kFewest) return std::nullopt;
  weights_.assign(matches_.size(), 1);
  Result result;
  for (int round = 1;; ++round) {
    Matrix6d H = Matrix6d::Zero();
    Eigen::Matrix<double, 6, 3> h = Eigen::Matrix<double, 6, 3>::Zero();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    for (size_t k = 0; k < matches_.size(); ++k) {
      const Match& m = matches_[k];
      const double weight = m.information * weights_[k];
      H += weight * m.by_motion.transpose() * m.by_motion;
      h += weight * m.by_motion.transpose() * m.by_shutter;
      square += weight * m.by_shutter.transpose() * m.by_shutter;
    }
    const Eigen::Matrix<double, 6, 3> explained = H.ldlt().solve(h);
    if (!explained.allFinite()) return std::nullopt;
    square -= h.transpose() * explained;
    if (round == kRounds) {
      result.equations = {square.topLeftCorner<2, 2>(), square.topRightCorner<2, 1>()};
      result.motion = explained.col(0);
      return result;
    }
    constexpr double kPrior = 1 / (kUsual * kUsual);
    weigh(explained, (square(0, 2) + kPrior * present) / (square(0, 0) + kPrior));
  }
}

void ReadoutComparison::weigh(const Eigen::Matrix<double, 6, 3>& explained, double readout) {
  constexpr double kScale2 = 4;  // squared sigmas at which a match counts a quarter
  const Eigen::Vector3d change(-readout, 0, 1);
  for (size_t k = 0; k < matches_.size(); ++k) {
    const Match& m = matches_[k];
    const Eigen::Vector2d left = (m.by_shutter - m.by_motion * explained) * change;
    const double root = 1 / (1 + m.information * left.squaredNorm() / kScale2);
    weights_[k] = root * root;
  }
}

}  // namespace covis
