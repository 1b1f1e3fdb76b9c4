// SPDX-License-Identifier: Apache-2.0
// The kernels that pay for SIMD. Each exists for every instruction set Highway knows on this machine, chosen at run
// time, and as a scalar twin that gives the same bits; the tests compare them all.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "covis/features/features.h"

namespace covis {

// The instruction sets that this machine and this build have, best first, by their Highway names in small letters, and
// at last "scalar", the twins. All give the same results.
std::vector<std::string> simd_targets();
// From now on one of those; "best": as at the start. False when there is none of that name. Not thread-safe.
bool use_simd_target(std::string_view name);
bool simd_enabled();  // not the scalar twins

// FAST-9/16 scores of `count` neighbouring pixels (fast_score() in fast.h) at a threshold; 3 rows must be there above
// and below, 3 pixels left and right, and 64 readable bytes behind.
void fast_score_row(const uint8_t* pixel, ptrdiff_t stride, int count, int threshold, uint8_t* out);

// Columns of `row` in [0, count) that are greater than all eight neighbours, in rising order; returns how many. One
// byte must be there to the left, 64 readable ones behind. `columns`: room for count.
int local_maxima_row(const uint8_t* above, const uint8_t* row, const uint8_t* below, int count, uint16_t* columns);

// --- The pyramid (pyramid.cpp has the scalar twins and chooses) ---

inline constexpr int kResizeBits = 11;  // bits of a bilinear weight
// Weights of exp(-x^2 / 8) for x = -3 ... 3, scaled to a sum of 256.
inline constexpr std::array<uint16_t, 7> kGauss = {18, 33, 49, 56, 49, 33, 18};
inline constexpr int kWidestRow = 32;  // least width of rows given to resize_rows and blur_row

// Eight neighbouring pixels of a row made smaller: the pairs each is mixed from, out of 16 bytes, and their weights.
struct alignas(16) ResizeGroup {
  std::array<uint8_t, 16> pick{};
  std::array<int16_t, 16> weight{};
  int32_t base = 0;  // column of the first byte
};

// out: 8 a group, scaled by 2^kResizeBits.
void resize_columns(const uint8_t* row, const ResizeGroup* groups, size_t count, uint32_t* out);
// Mixes two such rows; weight: of the one below.
void resize_rows(const uint32_t* above, const uint32_t* below, uint32_t weight, int width, uint8_t* out);

// One row blurred from the seven round it. line: scratch with room for 3 before and width + 40 from it on.
void blur_row(const uint8_t* const* rows, int width, int16_t* line, uint8_t* out);

// --- Patches (orb.cpp and stereo_matcher.cpp have the scalar twins and choose) ---

// Half widths of the rows 0 ... 15 of the disc whose centroid gives the orientation, symmetric about the diagonal.
inline constexpr std::array<int, 16> kDiscHalfWidth = {15, 15, 15, 15, 14, 14, 14, 13, 13, 12, 11, 10, 9, 8, 6, 3};

struct Moments {
  int x = 0, y = 0;  // sums of grey times column, grey times row
};
// 15 rows must be there above and below, 15 pixels left and 16 right.
Moments patch_moments(const uint8_t* pixel, ptrdiff_t stride);

// offsets[i] = round(x s + y c) * stride + round(x c - y s), for count points (a multiple of 16; arrays 64-byte
// aligned).
void turn_points(const float* x, const float* y, size_t count, float c, float s, int32_t stride, int32_t* offsets);

// sad[k], k in [0, 11): of the 11x11 patch with top left `a` and the one at b + k. 16 bytes are read from a and from
// each place.
void slide_sad(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b, int* sad);

}  // namespace covis
