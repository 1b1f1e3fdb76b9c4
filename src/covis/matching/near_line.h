// SPDX-License-Identifier: Apache-2.0
// Finds those of many image points that lie near a line, all in pixels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "covis/core/aligned.h"

namespace covis {

// Image points with the squared distance at which each counts as near, padded for SIMD.
class LinePoints {
 public:
  static constexpr size_t kStep = 64;  // points that are looked at together

  explicit LinePoints(size_t n) : size_(n), x_(padded()), y_(padded()), bound_(padded(), -1.0f) {}
  void set(size_t k, float x, float y, float bound) {
    x_[k] = x;
    y_[k] = y;
    bound_[k] = bound;
  }
  size_t size() const { return size_; }
  size_t padded() const { return (size_ + kStep - 1) / kStep * kStep; }
  const float* x() const { return x_.data(); }
  const float* y() const { return y_.data(); }
  const float* bound() const { return bound_.data(); }  // pixels^2; negative in the padding

 private:
  size_t size_;
  AlignedVector<float> x_, y_, bound_;
};

// The points with (a x + b y + c)^2 <= bound, rising; line = {a, b, c} with a^2 + b^2 = 1. `index` has room for
// points.size(); returns how many there are.
size_t near_line(const std::array<float, 3>& line, const LinePoints& points, uint32_t* index);

}  // namespace covis
