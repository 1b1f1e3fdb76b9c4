// SPDX-License-Identifier: Apache-2.0
#include "covis/features/fast.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "covis/features/simd.h"

namespace covis {
namespace {

constexpr std::array<std::array<int, 2>, 16> kCircle = {{{0, 3}, {1, 3}, {2, 2}, {3, 1}, {3, 0}, {3, -1}, {2, -2}, {1, -3},
                                                         {0, -3}, {-1, -3}, {-2, -2}, {-3, -1}, {-3, 0}, {-3, 1}, {-2, 2}, {-1, 3}}};

// Where the parabola through three scores has its top, relative to the middle one, which is the greatest.
float peak(int before, int at, int after) { return 0.5f * static_cast<float>(after - before) / static_cast<float>(2 * at - before - after); }

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
  // Scores outside [x0, x1) x [y0, y1) count too where they neighbour it.
  scores_.resize(image.width, image.height);
  const int sx0 = std::max(3, x0 - 1), sx1 = std::min(image.width - 3, x1 + 1);
  const int sy0 = std::max(3, y0 - 1), sy1 = std::min(image.height - 3, y1 + 1);
  for (int y = y0 - 1; y <= y1; ++y) {
    uint8_t* out = scores_.row(y);
    std::memset(out, 0, static_cast<size_t>(image.width));
    if (y < sy0 || y >= sy1) continue;
    fast_score_row(image.row(y) + sx0, image.stride, sx1 - sx0, low_threshold, out + sx0);
  }
  const int columns = std::max(1, (x1 - x0) / cell_size), rows = std::max(1, (y1 - y0) / cell_size);
  const auto cell_of = [&](int x, int y) {
    return static_cast<size_t>((y - y0) * rows / (y1 - y0) * columns + (x - x0) * columns / (x1 - x0));
  };
  cell_has_.assign(static_cast<size_t>(columns * rows), 0);
  for (int y = y0; y < y1; ++y) {
    const uint8_t* up = scores_.row(y - 1);
    const uint8_t* row = scores_.row(y);
    const uint8_t* down = scores_.row(y + 1);
    for (int x = x0; x < x1; ++x) {
      if (x + 8 <= x1) {  // most are 0: look at eight at once
        uint64_t eight;
        std::memcpy(&eight, row + x, 8);
        if (eight == 0) {
          x += 7;
          continue;
        }
      }
      const uint8_t s = row[x];
      if (s == 0) continue;
      if (s <= row[x - 1] || s <= row[x + 1] || s <= up[x - 1] || s <= up[x] || s <= up[x + 1] || s <= down[x - 1] ||
          s <= down[x] || s <= down[x + 1]) {
        continue;
      }
      all_.push_back({static_cast<int16_t>(x), static_cast<int16_t>(y), s, peak(row[x - 1], s, row[x + 1]), peak(up[x], s, down[x])});
      if (s >= threshold) cell_has_[cell_of(x, y)] = 1;
    }
  }
  for (const Corner& c : all_) {
    if (c.score >= threshold || !cell_has_[cell_of(c.x, c.y)]) corners.push_back(c);
  }
}

}  // namespace covis
