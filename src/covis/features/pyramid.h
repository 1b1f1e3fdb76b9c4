// SPDX-License-Identifier: Apache-2.0
// The image pyramid and the blur that descriptors are read from.
#pragma once

#include <array>
#include <vector>

#include "covis/core/image.h"
#include "covis/features/features.h"
#include "covis/features/simd.h"

namespace covis {

// Bilinear, in fixed point: weights of 11 bits, pixel centres mapped as (x + 0.5) * factor - 0.5, borders clamped. For
// making images smaller by less than 2. Keeps its tables for the next image of the same sizes.
class BilinearResizer {
 public:
  struct Tap {
    int index;   // index of the first pixel
    int next;    // index of the second
    int weight;  // weight of the second, 2^11 = all
  };
  void resize(ImageView<const uint8_t> from, ImageView<uint8_t> to);

 private:
  void make_groups();
  void mix_columns(const uint8_t* in, uint32_t* out) const;

  int from_width_ = 0, from_height_ = 0, to_width_ = 0, to_height_ = 0;
  std::vector<Tap> columns_, rows_;
  std::vector<ResizeGroup> groups_;             // the columns for SIMD; empty where 16 bytes do not span eight
  std::array<std::vector<uint32_t>, 2> lines_;  // the two source rows in use, resized along x
  std::array<int, 2> held_{};
};

// Gaussian 7x7, sigma 2, borders reflected without repeating the edge; separable, 8-bit weights, rounded once at the
// end.
class GaussianBlur {
 public:
  void apply(ImageView<const uint8_t> from, ImageU8& to);

 private:
  void apply_scalar(ImageView<const uint8_t> from, ImageU8& to);

  std::vector<int16_t> line_;   // SIMD: a row blurred along y
  std::vector<uint16_t> rows_;  // scalar: 7 rows blurred along x, a ring
};

}  // namespace covis
