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

  // Mean tone of `taps` points in a line, (du, dv) apart, with (u, v) in their middle, for pixels that cover 2^lod
  // texels of level 0.
  float sample(float u, float v, float du, float dv, int taps, float lod) const {
    // The point before the first; the points lie strictly between this one and the one after the last.
    const float half = 0.5f * static_cast<float>(taps + 1);
    const float cell_u = std::floor(u), cell_v = std::floor(v);
    u -= cell_u;
    v -= cell_v;
    const bool folds = u - half * std::abs(du) < 0 || u + half * std::abs(du) > 1 || v - half * std::abs(dv) < 0 ||
                       v + half * std::abs(dv) > 1;
    if (static_cast<int>(cell_u) & 1) {  // every other repeat is mirrored
      u = 1 - u;
      du = -du;
    }
    if (static_cast<int>(cell_v) & 1) {
      v = 1 - v;
      dv = -dv;
    }
    const float level = std::clamp(lod, 0.0f, max_lod_);
    const size_t fine = static_cast<size_t>(level + kNearLevel);
    const float t = level - static_cast<float>(fine);
    const float tone =
        folds && taps > 1 ? folded(levels_[fine], u, v, du, dv, taps) : line(levels_[fine], u, v, du, dv, taps);
    if (t < kNearLevel) return tone;
    const Level& coarse = levels_[fine + 1];
    return tone +
           t * ((folds && taps > 1 ? folded(coarse, u, v, du, dv, taps) : line(coarse, u, v, du, dv, taps)) - tone);
  }

 private:
  struct Level {
    float columns, rows;  // texels
    int stride;           // of the padded rows
    size_t offset;        // of the first padded texel
  };

  // Levels this near (in lod) are taken for the level itself: saves look-ups where the difference would not be seen.
  static constexpr float kNearLevel = 0.06f;

  // Sum over a line of points that stays inside the texture, in 1/256 texel.
  float line(const Level& level, float u, float v, float du, float dv, int taps) const {
    const float before = 0.5f * static_cast<float>(taps - 1);
    // Each level is stored with a border of one repeated texel, which the half-texel shift reaches into.
    int x = static_cast<int>(((u - before * du) * level.columns + 0.5f) * 256);
    int y = static_cast<int>(((v - before * dv) * level.rows + 0.5f) * 256);
    const int dx = static_cast<int>(du * level.columns * 256), dy = static_cast<int>(dv * level.rows * 256);
    const uint8_t* texels = texels_.data() + level.offset;
    int64_t sum = 0;
    for (int i = 0; i < taps; ++i, x += dx, y += dy) {
      const uint8_t* p = texels + (y >> 8) * level.stride + (x >> 8);
      const int fx = x & 255, fy = y & 255;
      const int top = p[0] * (256 - fx) + p[1] * fx;
      const int bottom = p[level.stride] * (256 - fx) + p[level.stride + 1] * fx;
      sum += top * (256 - fy) + bottom * fy;
    }
    return static_cast<float>(sum) * (1.0f / 65536.0f) / static_cast<float>(taps);
  }
  // The same for a line that crosses the texture's border, point by point.
  float folded(const Level& level, float u, float v, float du, float dv, int taps) const {
    float sum = 0;
    for (int i = 0; i < taps; ++i) {
      const float at = static_cast<float>(i) - 0.5f * static_cast<float>(taps - 1);
      sum += line(level, mirror(u + at * du), mirror(v + at * dv), 0, 0, 1);
    }
    return sum / static_cast<float>(taps);
  }
  static float mirror(float t) {
    const float m = t - 2 * std::floor(t * 0.5f);
    return std::min(m, 2 - m);
  }
  void append_level(const std::vector<float>& values, int columns, int rows);

  std::vector<uint8_t> texels_;
  std::vector<Level> levels_;
  float max_lod_ = 0;
};

}  // namespace covis::synth
