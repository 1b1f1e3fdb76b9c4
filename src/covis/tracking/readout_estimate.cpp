// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/readout_estimate.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace covis {
namespace {

constexpr double kUsualFreedom = 6;  // degrees of freedom of the variance that is usual

double freedom_of(double blocks) { return kUsualFreedom + blocks - 1; }

}  // namespace

void ReadoutEstimate::add(const ReadoutEquations& of_frame) {
  block_ += of_frame;
  if (++frames_ < kFramesOfBlock) return;
  frames_ = 0;
  if (blocks_.size() < kMostBlocks) {
    blocks_.push_back(std::exchange(block_, {}));
  } else {
    blocks_[next_] = std::exchange(block_, {});
    next_ = (next_ + 1) % kMostBlocks;
  }
}

void ReadoutEstimate::restart() {
  blocks_.clear();
  next_ = 0;
  block_ = {};
  frames_ = 0;
}

// The quantile of Student's t that belongs to 3.5 sigma of a normal distribution: a run asks again with each key frame,
// and chance has many goes.
// Source: Wallace, "Bounds on normal approximations to Student's and the chi-square distributions", Annals of
// Mathematical Statistics 30, 1959.
double ReadoutEstimate::Value::by_chance() const {
  constexpr double kNormal = 3.5;
  const double freedom = freedom_of(blocks);
  const double normal = kNormal * (8 * freedom + 3) / (8 * freedom + 1);
  return sigma * std::sqrt(freedom * std::expm1(normal * normal / freedom));
}

// A lens that is not as given, or points that move, are no chance: they look like a readout in all frames, but a small
// one for how fast the camera turns.
double ReadoutEstimate::Value::sure() const {
  constexpr double kShared = 2;
  return std::max(by_chance(), kShared * one_frame);
}

// Residuals of neighbouring frames err alike: the variance is that of blocks of frames, and a block counts for as much
// as it tells. A few blocks tell a variance badly, so that what was usual before joins them: standard deviations are
// four times what keypoints that err alone would have, by six degrees of freedom (an inverse gamma prior).
std::optional<ReadoutEstimate::Value> ReadoutEstimate::value() const {
  constexpr double kLeastBlocks = 2, kUsual = 4;
  ReadoutEquations all;
  for (const ReadoutEquations& block : blocks_) all += block;
  if (!(all.H(1, 1) > 0)) return std::nullopt;
  const Eigen::Vector2d alone(1, -all.H(0, 1) / all.H(1, 1));  // a change of the readout that changes the row with it
  const double information = alone.dot(all.H * alone);
  if (!(information > 0)) return std::nullopt;
  const double readout = alone.dot(all.b) / information;
  const double row = (all.b.y() - all.H(0, 1) * readout) / all.H(1, 1);
  double squares = 0, squared_shares = 0;
  for (const ReadoutEquations& block : blocks_) {
    const double residual = alone.dot(block.b - block.H * Eigen::Vector2d(readout, row));
    const double share = alone.dot(block.H * alone) / information;
    squares += residual * residual;
    squared_shares += share * share;
  }
  const double blocks = 1 / squared_shares;
  if (!(blocks >= kLeastBlocks)) return std::nullopt;
  const double sum = squares * blocks / (information * information) + kUsualFreedom * kUsual * kUsual / information;
  return Value{readout, std::sqrt(sum / freedom_of(blocks)), blocks, std::sqrt(kFramesOfBlock * blocks / information)};
}

}  // namespace covis
