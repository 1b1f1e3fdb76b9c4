// SPDX-License-Identifier: Apache-2.0
// A grey texture with its mip chain. Look-ups (shading.h) are bilinear within a level and linear between two.
// Source: Williams, "Pyramidal parametrics", SIGGRAPH 1983.
#pragma once

#include <cstdint>
#include <vector>

#include "synth/render/canvas.h"

namespace covis::synth {

// Level l has columns[l] x rows[l] texels in rows of stride[l] bytes, starting at offset[l]. Each level has a border of
// one repeated texel before the first column and row and two after the last, so that a look-up half a texel outside
// needs no special case; four bytes may be read from any texel.
struct TextureView {
  const uint8_t* texels;
  const float *columns, *rows;
  const int32_t *stride, *offset;
  float max_lod;  // number of the last level
};

class Texture {
 public:
  explicit Texture(const Canvas& canvas);
  // Takes columns times rows tones, row by row.
  Texture(std::vector<float> tones, int columns, int rows);

  TextureView view() const {
    return {texels_.data(), columns_.data(), rows_.data(),
            stride_.data(), offset_.data(),  static_cast<float>(columns_.size() - 1)};
  }

 private:
  void append_level(const std::vector<float>& values, int columns, int rows);

  std::vector<uint8_t> texels_;
  std::vector<float> columns_, rows_;
  std::vector<int32_t> stride_, offset_;
};

}  // namespace covis::synth
