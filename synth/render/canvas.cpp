// SPDX-License-Identifier: Apache-2.0
#include "synth/render/canvas.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "covis/core/random.h"

namespace covis::synth {
namespace {

// Glyphs of 5 x 7 dots, a row in each byte's low five bits, top row first: A to Z, then 0 to 9.
constexpr std::array<std::array<uint8_t, 7>, 36> kGlyphs{{
    {14, 17, 17, 31, 17, 17, 17}, {30, 17, 17, 30, 17, 17, 30}, {14, 17, 16, 16, 16, 17, 14},
    {30, 17, 17, 17, 17, 17, 30}, {31, 16, 16, 30, 16, 16, 31}, {31, 16, 16, 30, 16, 16, 16},
    {14, 17, 16, 23, 17, 17, 15}, {17, 17, 17, 31, 17, 17, 17}, {14, 4, 4, 4, 4, 4, 14},
    {1, 1, 1, 1, 1, 17, 14},      {17, 18, 20, 24, 20, 18, 17}, {16, 16, 16, 16, 16, 16, 31},
    {17, 27, 21, 21, 17, 17, 17}, {17, 25, 21, 19, 17, 17, 17}, {14, 17, 17, 17, 17, 17, 14},
    {30, 17, 17, 30, 16, 16, 16}, {14, 17, 17, 17, 21, 18, 13}, {30, 17, 17, 30, 20, 18, 17},
    {15, 16, 16, 14, 1, 1, 30},   {31, 4, 4, 4, 4, 4, 4},       {17, 17, 17, 17, 17, 17, 14},
    {17, 17, 17, 17, 17, 10, 4},  {17, 17, 17, 21, 21, 27, 17}, {17, 17, 10, 4, 10, 17, 17},
    {17, 17, 10, 4, 4, 4, 4},     {31, 1, 2, 4, 8, 16, 31},     {14, 17, 19, 21, 25, 17, 14},
    {4, 12, 4, 4, 4, 4, 14},      {14, 17, 1, 6, 8, 16, 31},    {31, 1, 2, 6, 1, 17, 14},
    {2, 6, 10, 18, 31, 2, 2},     {31, 16, 30, 1, 1, 17, 14},   {6, 8, 16, 30, 17, 17, 14},
    {31, 1, 2, 4, 8, 8, 8},       {14, 17, 17, 14, 17, 17, 14}, {14, 17, 17, 15, 1, 2, 12},
}};

double smooth_step(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

float lattice(uint64_t seed, int64_t x, int64_t y) {
  const uint64_t h =
      mix64(seed ^ (static_cast<uint64_t>(x) * 0x8da6b343ull) ^ (static_cast<uint64_t>(y) * 0xd8163841ull));
  return static_cast<float>(static_cast<double>(h >> 40) * 0x1.0p-23 - 1.0);
}

}  // namespace

Canvas::Canvas(double width, double height, double pixels_per_metre, double tone)
    : width_(width),
      height_(height),
      scale_(pixels_per_metre),
      columns_(static_cast<int>(std::clamp(std::ceil(width * pixels_per_metre - 1e-6), 4.0, 4096.0))),
      rows_(static_cast<int>(std::clamp(std::ceil(height * pixels_per_metre - 1e-6), 4.0, 4096.0))) {
  x_scale_ = columns_ / width_;
  y_scale_ = rows_ / height_;
  scale_ = std::min(x_scale_, y_scale_);
  pixels_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), static_cast<float>(tone));
}

void Canvas::rect(double x0, double y0, double x1, double y1, double tone, double alpha) {
  const double cx = 0.5 * (x0 + x1), cy = 0.5 * (y0 + y1), hx = 0.5 * (x1 - x0), hy = 0.5 * (y1 - y0);
  // The cover by the distance is the smaller of those by the distance across and down, each the same for a whole column
  // or row.
  const auto cover = [&](double at, double centre, double half) {
    return static_cast<float>(std::clamp(0.5 - (std::abs(at - centre) - half) * scale_, 0.0, 1.0) * alpha);
  };
  const Span columns = columns_over(x0, x1), rows = rows_over(y0, y1);
  std::vector<float> across;
  for (int c = columns.begin; c < columns.end; ++c) across.push_back(cover((c + 0.5) / x_scale_, cx, hx));
  const float to = static_cast<float>(tone);
  for (int r = rows.begin; r < rows.end; ++r) {
    const float down = cover((r + 0.5) / y_scale_, cy, hy);
    float* v = pixels_.data() + static_cast<ptrdiff_t>(r) * columns_ + columns.begin;
    for (const float share : across) {
      *v += std::min(share, down) * (to - *v);
      ++v;
    }
  }
}

void Canvas::frame(double x0, double y0, double x1, double y1, double line, double tone, double alpha) {
  rect(x0, y0, x1, y0 + line, tone, alpha);
  rect(x0, y1 - line, x1, y1, tone, alpha);
  rect(x0, y0 + line, x0 + line, y1 - line, tone, alpha);
  rect(x1 - line, y0 + line, x1, y1 - line, tone, alpha);
}

void Canvas::disc(double x, double y, double radius, double tone, double alpha) {
  ellipse(x, y, radius, radius, tone, alpha);
}

void Canvas::ellipse(double cx, double cy, double rx, double ry, double tone, double alpha) {
  const double r = std::min(rx, ry), inverse_x = 1 / rx, inverse_y = 1 / ry;
  paint(cx - rx, cy - ry, cx + rx, cy + ry, tone, alpha, [=](double x, double y) {
    const double dx = (x - cx) * inverse_x, dy = (y - cy) * inverse_y;
    return (std::sqrt(dx * dx + dy * dy) - 1) * r;
  });
}

void Canvas::line(double x0, double y0, double x1, double y1, double width, double tone, double alpha) {
  const double dx = x1 - x0, dy = y1 - y0, length2 = dx * dx + dy * dy + 1e-12, h = 0.5 * width;
  paint(std::min(x0, x1) - h, std::min(y0, y1) - h, std::max(x0, x1) + h, std::max(y0, y1) + h, tone, alpha,
        [=](double x, double y) {
          const double t = std::clamp(((x - x0) * dx + (y - y0) * dy) / length2, 0.0, 1.0);
          const double ex = x - x0 - t * dx, ey = y - y0 - t * dy;
          return std::sqrt(ex * ex + ey * ey) - h;
        });
}

void Canvas::triangle(const double (&px)[3], const double (&py)[3], double tone, double alpha) {
  const double area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0]);
  double nx[3], ny[3], at[3];  // each side as nx x + ny y + at = 0, positive outside
  for (int i = 0; i < 3; ++i) {
    const int k = (i + 1) % 3;
    const double ex = px[k] - px[i], ey = py[k] - py[i],
                 scale = (area > 0 ? 1 : -1) / (std::sqrt(ex * ex + ey * ey) + 1e-12);
    nx[i] = ey * scale;
    ny[i] = -ex * scale;
    at[i] = -nx[i] * px[i] - ny[i] * py[i];
  }
  paint(
      std::min({px[0], px[1], px[2]}), std::min({py[0], py[1], py[2]}), std::max({px[0], px[1], px[2]}),
      std::max({py[0], py[1], py[2]}), tone, alpha, [&](double x, double y) {
        return std::max({nx[0] * x + ny[0] * y + at[0], nx[1] * x + ny[1] * y + at[1], nx[2] * x + ny[2] * y + at[2]});
      });
}

double Canvas::text(double x, double y, double height, std::string_view letters, double tone) {
  const double dot = height / 7;
  for (const char letter : letters) {
    const bool capital = letter >= 'A' && letter <= 'Z', digit = letter >= '0' && letter <= '9';
    if (capital || digit) {
      const auto& glyph = kGlyphs[static_cast<size_t>(capital ? letter - 'A' : letter - '0' + 26)];
      for (size_t r = 0; r < 7; ++r) {
        for (int c = 0; c < 5; ++c) {
          if (!(glyph[r] >> (4 - c) & 1)) continue;
          rect(x + c * dot, y + static_cast<double>(r) * dot, x + (c + 1) * dot, y + static_cast<double>(r + 1) * dot,
               tone);
        }
      }
    }
    x += 6 * dot;
  }
  return 6 * dot * static_cast<double>(letters.size());
}

void Canvas::noise(double cell_x, double cell_y, double amplitude, uint64_t seed) {
  const size_t columns = static_cast<size_t>(columns_);
  std::vector<size_t> cell_end;  // the column after each cell's last
  std::vector<float> weight(columns);
  for (size_t c = 0; c < columns; ++c) {
    const double t = (static_cast<double>(c) + 0.5) / x_scale_ / cell_x;
    cell_end.resize(static_cast<size_t>(t) + 1, c);
    cell_end.back() = c + 1;
    weight[c] = static_cast<float>(smooth_step(t - std::floor(t)));
  }
  const size_t lattice_columns = cell_end.size() + 1;
  std::vector<float> mixed(lattice_columns), above(lattice_columns), below(lattice_columns);
  const auto fill = [&](std::vector<float>& values, int y) {
    for (size_t i = 0; i < lattice_columns; ++i) values[i] = lattice(seed, static_cast<int64_t>(i), y);
  };
  int current = -1;
  for (int r = 0; r < rows_; ++r) {
    const double t = (r + 0.5) / y_scale_ / cell_y;
    const int row = static_cast<int>(t);
    if (row != current) {
      if (row == current + 1 && current >= 0) {
        above.swap(below);
      } else {
        fill(above, row);
      }
      fill(below, row + 1);
      current = row;
    }
    const float wy = static_cast<float>(smooth_step(t - row)), a = static_cast<float>(amplitude);
    for (size_t i = 0; i < lattice_columns; ++i) mixed[i] = a * (above[i] + wy * (below[i] - above[i]));
    float* out = pixels_.data() + static_cast<size_t>(r) * columns;
    size_t c = 0;
    for (size_t i = 0; i < cell_end.size(); ++i) {
      const float left = mixed[i], step = mixed[i + 1] - left;
      for (const size_t end = cell_end[i]; c < end; ++c) out[c] += left + weight[c] * step;
    }
  }
}

void Canvas::fractal(double cell, double amplitude, int octaves, double gain, uint64_t seed) {
  for (int i = 0; i < octaves; ++i) {
    noise(cell, cell, amplitude, hash_seed(seed, static_cast<uint64_t>(i)));
    cell *= 0.5;
    amplitude *= gain;
    if (cell * scale_ < 1) return;  // cells smaller than a pixel are not visible
  }
}

void Canvas::grain(double amplitude, uint64_t seed) {
  Random random(seed);
  for (float& v : pixels_) v += static_cast<float>(random.uniform(-amplitude, amplitude));
}

void Canvas::spots(double count, double radius_min, double radius_max, double tone, double alpha, uint64_t seed) {
  Random random(seed);
  const int n = static_cast<int>(count * width_ * height_);
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(0, width_), y = random.uniform(0, height_);
    const double r = random.uniform(radius_min, radius_max);
    ellipse(x, y, r, r * random.uniform(0.6, 1.0), tone, alpha * random.uniform(0.4, 1.0));
  }
}

void Canvas::shadow(double x0, double y0, double x1, double y1, double soft, double strength) {
  const double cx = 0.5 * (x0 + x1), cy = 0.5 * (y0 + y1), hx = 0.5 * (x1 - x0), hy = 0.5 * (y1 - y0);
  each_pixel(x0 - soft, y0 - soft, x1 + soft, y1 + soft, [&](double x, double y, float& v) {
    const double dx = std::abs(x - cx) - hx, dy = std::abs(y - cy) - hy;
    const double outside = std::hypot(std::max(dx, 0.0), std::max(dy, 0.0)) + std::min(std::max(dx, dy), 0.0);
    const double t = std::clamp(0.5 - 0.5 * outside / soft, 0.0, 1.0);
    v *= static_cast<float>(1 - strength * t * t * (3 - 2 * t));
  });
}

void Canvas::darken_edges(double reach, double strength) {
  const auto factors = [&](int count, double size) {
    std::vector<float> f(static_cast<size_t>(count));
    for (int i = 0; i < count; ++i) {
      const double at = (i + 0.5) / count * size;
      f[static_cast<size_t>(i)] = static_cast<float>(1 - strength * std::exp(-3 * std::min(at, size - at) / reach));
    }
    return f;
  };
  const std::vector<float> across = factors(columns_, width_), down = factors(rows_, height_);
  size_t i = 0;
  for (const float d : down) {
    for (const float a : across) pixels_[i++] *= d * a;
  }
}

void Canvas::clamp_tones(double low, double high) {
  for (float& v : pixels_) v = std::clamp(v, static_cast<float>(low), static_cast<float>(high));
}

}  // namespace covis::synth
