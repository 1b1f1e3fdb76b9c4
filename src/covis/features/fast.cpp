// SPDX-License-Identifier: Apache-2.0
#include "covis/features/fast.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "covis/features/simd.h"

namespace covis {
namespace {

constexpr std::array<std::array<int, 2>, 16> kCircle = {{{0, 3},
                                                         {1, 3},
                                                         {2, 2},
                                                         {3, 1},
                                                         {3, 0},
                                                         {3, -1},
                                                         {2, -2},
                                                         {1, -3},
                                                         {0, -3},
                                                         {-1, -3},
                                                         {-2, -2},
                                                         {-3, -1},
                                                         {-3, 0},
                                                         {-3, 1},
                                                         {-2, 2},
                                                         {-1, 3}}};

}  // namespace

int fast_score(const uint8_t* pixel, ptrdiff_t stride, int threshold) {
  const int p = *pixel;
  // Nine contiguous pixels always contain one of each opposite pair: two quick tests reject most pixels.
  const auto at = [&](size_t k) { return static_cast<int>(pixel[kCircle[k][1] * stride + kCircle[k][0]]) - p; };
  const int d0 = at(0), d8 = at(8), d4 = at(4), d12 = at(12);
  const bool bright = std::max(d0, d8) > threshold && std::max(d4, d12) > threshold;
  const bool dark = std::min(d0, d8) < -threshold && std::min(d4, d12) < -threshold;
  if (!bright && !dark) return 0;
  std::array<int, 25> d;
  for (size_t k = 0; k < 16; ++k) d[k] = at(k);
  for (size_t k = 16; k < 25; ++k) d[k] = d[k - 16];
  int best = 0;
  for (size_t start = 0; start < 16; ++start) {
    int low = d[start], high = d[start];
    for (size_t k = start + 1; k < start + 9; ++k) {
      low = std::min(low, d[k]);
      high = std::max(high, d[k]);
    }
    best = std::max({best, low, -high});
  }
  return best > threshold ? best - 1 : 0;
}

void FastDetector::detect(ImageView<const uint8_t> image, int border, int cell_size, int threshold, int low_threshold,
                          std::vector<Corner>& corners) {
  corners.clear();
  const int x0 = border, y0 = border, x1 = image.width - border, y1 = image.height - border;
  if (x1 <= x0 || y1 <= y0) return;
  // Reserves room for a corner at every sixteenth pixel; memory pages are used only when filled.
  for (auto* list : {&in_row_, &corners}) list->reserve(static_cast<size_t>((x1 - x0) * (y1 - y0) / 16));
  // Neighbouring scores outside [x0, x1) x [y0, y1) count too. A ring of three rows is kept.
  scores_.resize(image.width, 3);
  std::memset(scores_.row(0), 0, static_cast<size_t>(3 * scores_.stride()));
  const int sx0 = std::max(3, x0 - 1), sx1 = std::min(image.width - 3, x1 + 1);
  const auto score = [&](int y) {
    uint8_t* out = scores_.row(y % 3);
    if (y < 3 || y >= image.height - 3) {
      std::memset(out, 0, static_cast<size_t>(image.width));
    } else {
      fast_score_row(image.row(y) + sx0, image.stride, sx1 - sx0, low_threshold, out + sx0);
    }
  };
  const int columns = std::max(1, (x1 - x0) / cell_size), rows = std::max(1, (y1 - y0) / cell_size);
  // The first pixel of a cell, and, of the last one, the pixel after it.
  const auto first_of = [](int cell, int cells, int pixels) { return (cell * pixels + cells - 1) / cells; };
  column_of_.resize(static_cast<size_t>(x1 - x0));
  for (int c = 0; c < columns; ++c) {
    const auto from = column_of_.begin();
    std::fill(from + first_of(c, columns, x1 - x0), from + first_of(c + 1, columns, x1 - x0), static_cast<uint16_t>(c));
  }
  maxima_.resize(static_cast<size_t>(x1 - x0));
  score(y0 - 1);
  score(y0);
  for (int cell_row = 0; cell_row < rows; ++cell_row) {
    in_row_.clear();
    has_strong_.assign(static_cast<size_t>(columns), 0);
    const int last = y0 + first_of(cell_row + 1, rows, y1 - y0);
    for (int y = y0 + first_of(cell_row, rows, y1 - y0); y < last; ++y) {
      score(y + 1);
      const uint8_t* up = scores_.row((y - 1) % 3) + x0;
      const uint8_t* row = scores_.row(y % 3) + x0;
      const uint8_t* down = scores_.row((y + 1) % 3) + x0;
      const int found = local_maxima_row(up, row, down, x1 - x0, maxima_.data());
      for (int k = 0; k < found; ++k) {
        const int x = maxima_[static_cast<size_t>(k)];
        const uint8_t s = row[x];
        in_row_.push_back(
            {static_cast<int16_t>(x0 + x), static_cast<int16_t>(y), s, row[x - 1], row[x + 1], up[x], down[x]});
        has_strong_[column_of_[static_cast<size_t>(x)]] |= s >= threshold;
      }
    }
    keep_of_row(x0, threshold, corners);
  }
}

// Without a branch that depends on the image, which would be mispredicted often.
void FastDetector::keep_of_row(int x0, int threshold, std::vector<Corner>& corners) {
  size_t count = corners.size();
  corners.resize(count + in_row_.size());
  for (const Corner& c : in_row_) {
    corners[count] = c;
    const bool alone = has_strong_[column_of_[static_cast<size_t>(c.x - x0)]] == 0;
    count += static_cast<size_t>((c.score >= threshold) | alone);
  }
  corners.resize(count);
}

}  // namespace covis
