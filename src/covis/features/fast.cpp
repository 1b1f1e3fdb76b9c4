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

// The place of the top of the parabola through three scores, relative to the middle one, which is the greatest.
float peak(int before, int at, int after) {
  return 0.5f * static_cast<float>(after - before) / static_cast<float>(2 * at - before - after);
}

}  // namespace

int fast_score(const uint8_t* pixel, ptrdiff_t stride, int threshold) {
  const int p = *pixel;
  // Nine in a row always hold one of each opposite pair: two quick looks reject most pixels.
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
  all_.clear();
  const int x0 = border, y0 = border, x1 = image.width - border, y1 = image.height - border;
  if (x1 <= x0 || y1 <= y0) return;
  // Room for a corner in every sixteenth pixel, memory for which is used only when they come.
  for (auto* list : {&all_, &corners}) list->reserve(static_cast<size_t>((x1 - x0) * (y1 - y0) / 16));
  // Scores outside [x0, x1) x [y0, y1) count too where they neighbour it. Three rows of them are held.
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
  cell_column_.resize(static_cast<size_t>(image.width));
  for (int x = x0; x < x1; ++x)
    cell_column_[static_cast<size_t>(x)] = static_cast<uint16_t>((x - x0) * columns / (x1 - x0));
  const auto cell_row = [&](int y) { return static_cast<size_t>((y - y0) * rows / (y1 - y0) * columns); };
  cell_has_.assign(static_cast<size_t>(columns * rows), 0);
  maxima_.resize(static_cast<size_t>(x1 - x0));
  score(y0 - 1);
  score(y0);
  for (int y = y0; y < y1; ++y) {
    score(y + 1);
    const uint8_t* up = scores_.row((y - 1) % 3);
    const uint8_t* row = scores_.row(y % 3);
    const uint8_t* down = scores_.row((y + 1) % 3);
    const size_t cells = cell_row(y);
    const int found = local_maxima_row(up + x0, row + x0, down + x0, x1 - x0, maxima_.data());
    for (int k = 0; k < found; ++k) {
      const int x = x0 + maxima_[static_cast<size_t>(k)];
      const uint8_t s = row[x];
      all_.push_back({static_cast<int16_t>(x), static_cast<int16_t>(y), s, peak(row[x - 1], s, row[x + 1]),
                      peak(up[x], s, down[x])});
      if (s >= threshold) cell_has_[cells + cell_column_[static_cast<size_t>(x)]] = 1;
    }
  }
  for (const Corner& c : all_) {
    if (c.score >= threshold || !cell_has_[cell_row(c.y) + cell_column_[static_cast<size_t>(c.x)]])
      corners.push_back(c);
  }
}

}  // namespace covis
