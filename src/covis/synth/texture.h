// SPDX-License-Identifier: Apache-2.0
// A grey texture with its mip chain, sampled bilinearly within a level and linearly between two. Coordinates run over
// [0, 1] and repeat mirrored beyond, so that no seam shows. Source: Williams, "Pyramidal parametrics", SIGGRAPH 1983.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "covis/synth/canvas.h"

namespace covis::synth {

class Texture {
 public:
  explicit Texture(const Canvas& canvas);

  float columns() const { return levels_[0].columns; }
  float rows() const { return levels_[0].rows; }

  // Tone at (u, v) for pixels that cover 2^lod texels of level 0.
  float sample(float u, float v, float lod) const {
    u = mirror(u);
    v = mirror(v);
    if (lod <= 0) return bilinear(levels_[0], u, v);
    if (lod >= max_lod_) return bilinear(levels_.back(), u, v);
    const int level = static_cast<int>(lod);
    const float t = lod - static_cast<float>(level);
    const float fine = bilinear(levels_[static_cast<size_t>(level)], u, v);
    return fine + t * (bilinear(levels_[static_cast<size_t>(level) + 1], u, v) - fine);
  }

 private:
  struct Level {
    float columns, rows;  // texels
    int stride;           // of the padded rows
    size_t offset;        // of the first padded texel
  };

  static float mirror(float t) {
    const float m = t - 2 * std::floor(t * 0.5f);
    return std::min(m, 2 - m);
  }
  float bilinear(const Level& level, float u, float v) const {
    // Each level is stored with a border of one repeated texel, which the half-texel shift reaches into.
    const int x = static_cast<int>((u * level.columns + 0.5f) * 256),
              y = static_cast<int>((v * level.rows + 0.5f) * 256);
    const uint8_t* p = texels_.data() + level.offset + (y >> 8) * level.stride + (x >> 8);
    const int fx = x & 255, fy = y & 255;
    const int top = p[0] * (256 - fx) + p[1] * fx;
    const int bottom = p[level.stride] * (256 - fx) + p[level.stride + 1] * fx;
    return static_cast<float>(top * (256 - fy) + bottom * fy) * (1.0f / 65536.0f);
  }
  void append_level(const std::vector<float>& values, int columns, int rows);

  std::vector<uint8_t> texels_;
  std::vector<Level> levels_;
  float max_lod_ = 0;
};

}  // namespace covis::synth
