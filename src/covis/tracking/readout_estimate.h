// SPDX-License-Identifier: Apache-2.0
// The readout of a rolling shutter, from what many frames say of it: seconds from the exposure of the first row to that
// of the last.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace covis {

// Normal equations of the readout in seconds and the error of the principal point's row in pixels: where the camera
// goes on turning as it did, a wrong row looks like a readout.
struct ReadoutEquations {
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();

  ReadoutEquations& operator+=(const ReadoutEquations& other) {
    H += other.H;
    b += other.b;
    return *this;
  }
};

class ReadoutEstimate {
 public:
  ReadoutEstimate() { blocks_.reserve(kMostBlocks); }
  void add(const ReadoutEquations& of_frame);
  void restart();

  struct Value {
    double readout = 0, sigma = 0;  // seconds
    double blocks = 0;              // as many as tell the same
    double one_frame = 0;  // standard deviation of what one of their frames tells, if keypoints erred alone, seconds

    // A difference that chance alone seldom has in a whole run, however often it is asked for, seconds.
    double by_chance() const;
    // A readout that is greater than what chance and errors that all frames share usually bring about, seconds.
    double sure() const;
  };
  // Nothing before enough was seen.
  std::optional<Value> value() const;

 private:
  static constexpr size_t kMostBlocks = 600;
  static constexpr int kFramesOfBlock = 5;

  std::vector<ReadoutEquations> blocks_;  // a ring of the last ones
  size_t next_ = 0;                       // place of the next block, once the ring is full
  ReadoutEquations block_;
  int frames_ = 0;  // in the block
};

}  // namespace covis
