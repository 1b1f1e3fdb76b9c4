// SPDX-License-Identifier: Apache-2.0
#include "synth/render/texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace covis::synth {
namespace {

enum class Along { rows, columns };

// Halves one dimension by area: output i covers [i, i + 1) * (size / half) of the input, so that odd sizes stay in
// place. `step` is the distance between neighbours, `lines` the number of lines, `line` the distance between lines.
std::vector<float> halve(const std::vector<float>& in, int size, int lines, Along along) {
  const int half = (size + 1) / 2;
  std::vector<float> out(static_cast<size_t>(half) * static_cast<size_t>(lines));
  const double ratio = static_cast<double>(size) / half;
  struct Share {
    int first, last;  // inputs
    float weight[3];
  };
  std::vector<Share> shares(static_cast<size_t>(half));
  for (int i = 0; i < half; ++i) {
    const double begin = i * ratio, end = std::min<double>((i + 1) * ratio, size);
    const int first = static_cast<int>(begin), last = std::min(size - 1, static_cast<int>(std::ceil(end - 1e-9)) - 1);
    Share& share = shares[static_cast<size_t>(i)] = {first, last, {0, 0, 0}};
    for (int k = first; k <= last; ++k) {
      share.weight[k - first] =
          static_cast<float>((std::min<double>(k + 1, end) - std::max<double>(k, begin)) / (end - begin));
    }
  }
  // Both walk through memory in its order.
  float* to = out.data();
  if (along == Along::rows) {
    const float* from = in.data();
    for (int l = 0; l < lines; ++l, from += size) {
      for (const Share& share : shares) {
        float sum = 0;
        for (int k = share.first; k <= share.last; ++k) sum += share.weight[k - share.first] * from[k];
        *to++ = sum;
      }
    }
    return out;
  }
  for (const Share& share : shares) {
    for (int k = share.first; k <= share.last; ++k) {
      const float weight = share.weight[k - share.first];
      const float* from = in.data() + static_cast<ptrdiff_t>(k) * lines;
      for (int l = 0; l < lines; ++l) to[l] += weight * from[l];
    }
    to += lines;
  }
  return out;
}

}  // namespace

Texture::Texture(const Canvas& canvas) : Texture(canvas.pixels(), canvas.columns(), canvas.rows()) {}

Texture::Texture(std::vector<float> tones, int columns, int rows) {
  append_level(tones, columns, rows);
  std::vector<float> values = std::move(tones);
  while (columns > 1 || rows > 1) {
    std::vector<float> narrow = halve(values, columns, rows, Along::rows);
    columns = (columns + 1) / 2;
    values = halve(narrow, rows, columns, Along::columns);
    rows = (rows + 1) / 2;
    append_level(values, columns, rows);
  }
  texels_.resize(texels_.size() + 4);  // a look-up of the last texel reads four bytes
}

void Texture::append_level(const std::vector<float>& values, int columns, int rows) {
  const int stride = columns + 3;  // one repeated texel before, two after: u = 1 rounds up to the last but one
  columns_.push_back(static_cast<float>(columns));
  rows_.push_back(static_cast<float>(rows));
  stride_.push_back(stride);
  offset_.push_back(static_cast<int32_t>(texels_.size()));
  texels_.resize(texels_.size() + static_cast<size_t>(stride) * static_cast<size_t>(rows + 3));
  uint8_t* to = texels_.data() + offset_.back();
  for (int y = -1; y < rows + 2; ++y) {
    const float* row = values.data() + static_cast<size_t>(std::clamp(y, 0, rows - 1)) * static_cast<size_t>(columns);
    const auto texel = [](float v) { return static_cast<uint8_t>(std::min(std::max(v, 0.0f), 255.0f) + 0.5f); };
    *to++ = texel(row[0]);
    for (int x = 0; x < columns; ++x) *to++ = texel(row[x]);
    *to++ = texel(row[columns - 1]);
    *to++ = texel(row[columns - 1]);
  }
}

}  // namespace covis::synth
