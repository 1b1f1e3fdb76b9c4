// SPDX-License-Identifier: Apache-2.0
// Procedural painting of textures: a grey float image measured in metres, with anti-aliased shapes, noise at chosen
// scales, lettering and soft shadows. Origin top left, x right, y down. Tones run from 0 (black) to 255 (white).
// Noise: value noise (lattice of hashed values, smooth interpolation), summed over octaves.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

namespace covis::synth {

class Canvas {
 public:
  // Size in metres, resolution in pixels per metre, initial tone. Sides are rounded up to whole pixels and kept within
  // [4, 4096] pixels.
  Canvas(double width, double height, double pixels_per_metre, double tone);

  double width() const { return width_; }
  double height() const { return height_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const std::vector<float>& pixels() const { return pixels_; }

  // Paints all pixels of a box where distance(x, y) < 0 (signed distance in metres) with `tone` and opacity `alpha`.
  template <class Distance>
  void paint(double x0, double y0, double x1, double y1, double tone, double alpha, Distance&& distance) {
    each_pixel(x0, y0, x1, y1, [&](double x, double y, float& v) {
      const double cover = std::clamp(0.5 - distance(x, y) * scale_, 0.0, 1.0) * alpha;
      v += static_cast<float>(cover) * (static_cast<float>(tone) - v);
    });
  }
  // Calls edit(x, y, value&) for each pixel of a box.
  template <class Edit>
  void each_pixel(double x0, double y0, double x1, double y1, Edit&& edit) {
    const Span columns = columns_over(x0, x1), rows = rows_over(y0, y1);
    for (int r = rows.begin; r < rows.end; ++r) {
      for (int c = columns.begin; c < columns.end; ++c) {
        edit((c + 0.5) / x_scale_, (r + 0.5) / y_scale_,
             pixels_[static_cast<size_t>(r) * static_cast<size_t>(columns_) + static_cast<size_t>(c)]);
      }
    }
  }

  void rect(double x0, double y0, double x1, double y1, double tone, double alpha = 1);
  // An outline of the given line width, inside the box.
  void frame(double x0, double y0, double x1, double y1, double line, double tone, double alpha = 1);
  void disc(double x, double y, double radius, double tone, double alpha = 1);
  void ellipse(double x, double y, double rx, double ry, double tone, double alpha = 1);
  void line(double x0, double y0, double x1, double y1, double width, double tone, double alpha = 1);
  void triangle(const double (&x)[3], const double (&y)[3], double tone, double alpha = 1);
  // Paints capital letters and digits, `height` metres high; other characters are spaces. Returns the width written.
  double text(double x, double y, double height, std::string_view letters, double tone);

  // Adds value noise with lattice cells of cell_x by cell_y metres and the given amplitude (greatest change of tone).
  void noise(double cell_x, double cell_y, double amplitude, uint64_t seed);
  // Adds octaves of noise, each with half the cell and `gain` times the amplitude of the one before.
  void fractal(double cell, double amplitude, int octaves, double gain, uint64_t seed);
  // Adds independent noise to each pixel.
  void grain(double amplitude, uint64_t seed);
  // Paints small round spots, `count` per square metre.
  void spots(double count, double radius_min, double radius_max, double tone, double alpha, uint64_t seed);
  // Darkens (strength > 0) a box with edges that fade over `soft` metres on both sides.
  void shadow(double x0, double y0, double x1, double y1, double soft, double strength);
  // Darkens towards the edges of the canvas: ambient occlusion of a wall, floor or ceiling.
  void darken_edges(double reach, double strength);
  void clamp_tones(double low, double high);

 private:
  struct Span {
    int begin, end;
  };
  // The columns and rows of pixels that may see something of a box.
  Span columns_over(double x0, double x1) const { return pixels_over(x0, x1, x_scale_, columns_); }
  Span rows_over(double y0, double y1) const { return pixels_over(y0, y1, y_scale_, rows_); }
  static Span pixels_over(double low, double high, double scale, int count) {
    return {std::max(0, static_cast<int>(std::floor(low * scale - 1))),
            std::min(count, static_cast<int>(std::ceil(high * scale + 1)))};
  }

  double width_, height_, scale_, x_scale_, y_scale_;
  int columns_, rows_;
  std::vector<float> pixels_;
};

}  // namespace covis::synth
