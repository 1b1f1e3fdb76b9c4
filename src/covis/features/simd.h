// SPDX-License-Identifier: Apache-2.0
// The kernels that pay for SIMD. Each exists for every instruction set Highway knows on this machine, chosen at run time, and as a
// scalar twin that gives the same bits; the tests compare them all.
#pragma once

#include <cstddef>
#include <cstdint>

#include "covis/features/features.h"

namespace covis {

// Off: the scalar twins are used from now on. For tests and measurements; not thread-safe.
void set_simd_enabled(bool enabled);
bool simd_enabled();

// FAST-9/16 scores of `count` neighbouring pixels (fast_score() in fast.h) at a threshold; 3 rows must be there above and below,
// 3 pixels left and right, and 64 readable bytes behind.
void fast_score_row(const uint8_t* pixel, ptrdiff_t stride, int count, int threshold, uint8_t* out);

// Columns of `row` in [0, count) that are greater than all eight neighbours, in rising order; returns how many. One byte must be
// there to the left, 64 readable ones behind. `columns`: room for count.
int local_maxima_row(const uint8_t* above, const uint8_t* row, const uint8_t* below, int count, uint16_t* columns);

}  // namespace covis
