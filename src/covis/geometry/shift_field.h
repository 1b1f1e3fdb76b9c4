// SPDX-License-Identifier: Apache-2.0
// How far an image shows things from where an ideal one would, in one direction: a polynomial of the place. It has the
// terms that a camera's errors have to first order: a shift, a turn about each of its axes, another focal length, and
// the first radial and the tangential coefficients of Brown's model.
// Source: Brown, "Close-range camera calibration", 1971.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace covis {

inline constexpr double kMostRectificationError = 4;  // pixels: a pair that is farther off is to be calibrated anew

struct ShiftField {
  static constexpr size_t kTerms = 7;
  using Terms = std::array<double, kTerms>;

  Terms pixels{};  // coefficients

  // The terms at a place: its coordinate in the direction of the shift and the other one, from the principal point, in
  // focal lengths.
  static Terms terms(double along, double across) {
    const double along2 = along * along, across2 = across * across;
    return {1, along, across, along * across, along2, across2, along * (along2 + across2)};
  }
  double at(double along, double across) const {
    const Terms terms_there = terms(along, across);
    double sum = 0;
    for (size_t k = 0; k < kTerms; ++k) sum += pixels[k] * terms_there[k];
    return sum;
  }
  bool any() const { return *this != ShiftField{}; }
  // A camera can be so.
  bool valid() const {
    constexpr double kMost = 1000;  // pixels
    for (const double p : pixels)
      if (!(std::abs(p) <= kMost)) return false;  // a NaN is none
    return true;
  }
  friend bool operator==(const ShiftField&, const ShiftField&) = default;
};

inline ShiftField operator+(ShiftField a, const ShiftField& b) {
  for (size_t k = 0; k < ShiftField::kTerms; ++k) a.pixels[k] += b.pixels[k];
  return a;
}

}  // namespace covis
