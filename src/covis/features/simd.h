// SPDX-License-Identifier: Apache-2.0
// The kernels that benefit from SIMD, each with a scalar twin (core/simd_targets.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "covis/features/features.h"
#include "covis/features/gradients.h"

namespace covis {

// FAST-9/16 scores of `count` neighbouring pixels (fast_score() in fast.h) at a threshold. The image must extend 3 rows
// above and below and 3 pixels left and right, with 64 readable bytes after the pixels.
void fast_score_row(const uint8_t* pixel, ptrdiff_t stride, int count, int threshold, uint8_t* out);

// Finds the columns of `row` in [0, count) that are greater than all eight neighbours, in ascending order; returns
// their number. One byte before and 64 bytes after the row must be readable. `columns`: room for count.
int local_maxima_row(const uint8_t* above, const uint8_t* row, const uint8_t* below, int count, uint16_t* columns);

// --- The pyramid (pyramid.cpp has the scalar twins and selects the implementation) ---

inline constexpr int kResizeBits = 11;  // bits of a bilinear weight
// Weights exp(-x^2 / 8) for x = -3 ... 3, scaled to a sum of 256.
inline constexpr std::array<uint16_t, 7> kGauss = {18, 33, 49, 56, 49, 33, 18};
inline constexpr int kWidestRow = 32;  // least width of rows for resize_rows and blur_row

// Eight neighbouring pixels of a resized row: the two source pixels of each, selected from 16 bytes, and their weights.
struct alignas(16) ResizeGroup {
  std::array<uint8_t, 16> pick{};
  std::array<int16_t, 16> weight{};
  int32_t base = 0;  // column of the first of the 16 bytes
};

// out: 8 values per group, scaled by 2^kResizeBits.
void resize_columns(const uint8_t* row, const ResizeGroup* groups, size_t count, uint32_t* out);
// Interpolates between two such rows; weight: weight of the lower row.
void resize_rows(const uint32_t* above, const uint32_t* below, uint32_t weight, int width, uint8_t* out);

// Blurs one row from the seven rows around it. line: scratch with room for 3 elements before it and width + 40 after.
void blur_row(const uint8_t* const* rows, int width, int16_t* line, uint8_t* out);

// --- Patches (orb.cpp, gradients.cpp and stereo_matcher.cpp have the scalar twins and select the implementation) ---

// Half widths of the rows 0 ... 15 of the disc whose centroid gives the orientation, symmetric about the diagonal.
inline constexpr std::array<int, 16> kDiscHalfWidth = {15, 15, 15, 15, 14, 14, 14, 13, 13, 12, 11, 10, 9, 8, 6, 3};

struct Moments {
  int x = 0, y = 0;  // sum of grey value times column, and times row
};
// The image must extend 15 rows above and below the pixel, 15 pixels to its left and 16 to its right.
Moments patch_moments(const uint8_t* pixel, ptrdiff_t stride);

// gradient_sums() in gradients.h.
void patch_gradients(const uint8_t* image, ptrdiff_t stride, const Corner* corners, size_t count, GradientSums* sums);

// Sets offsets[i] = round(x s + y c) * stride + round(x c - y s), for count points (a multiple of 16; arrays 64-byte
// aligned). Offsets have to be less than 2^24, as floats hold them.
void turn_points(const float* x, const float* y, size_t count, float c, float s, int32_t stride, int32_t* offsets);

// The difference of the means of two 11x11 patches in quarters of a grey level, rounded; `difference`: that of their
// sums.
constexpr int quarters_of_mean(int difference) {
  constexpr int kPixels = 121;
  return (4 * difference + (difference < 0 ? -kPixels / 2 : kPixels / 2)) / kPixels;
}

// Sets sad[k], k in [0, 11), to the sum of absolute differences, in quarters of a grey level, of the 11x11 patches with
// top left at `a` and at b + k, from each of which its mean was taken off: two eyes are rarely equally bright. From
// each row start at `a` 16 bytes are read, at `b` 24.
void slide_sad(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b, int* sad);

}  // namespace covis
