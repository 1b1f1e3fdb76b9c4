// SPDX-License-Identifier: Apache-2.0
// The image pyramid and the blur that descriptors are read from.
#pragma once

#include <vector>

#include "covis/core/image.h"
#include "covis/features/features.h"

namespace covis {

// Bilinear, in fixed point: weights of 11 bits, pixel centres mapped as (x + 0.5) * factor - 0.5, borders clamped.
void resize_bilinear(ImageView<const uint8_t> from, ImageView<uint8_t> to);

// Gaussian 7x7, sigma 2, borders reflected without repeating the edge; separable, 8-bit weights, rounded once at the end.
class GaussianBlur {
 public:
  void apply(ImageView<const uint8_t> from, ImageU8& to);

 private:
  std::vector<uint16_t> rows_;  // 7 horizontally blurred rows, a ring
};

}  // namespace covis
