// SPDX-License-Identifier: Apache-2.0
#include "covis/features/features.h"

#include <cassert>

namespace covis {

ScalePyramid::ScalePyramid(int level_count, float scale_factor)
    : levels(level_count), factor(scale_factor), log_factor(std::log(scale_factor)) {
  float s = 1;
  for (int l = 0; l < levels; ++l, s *= factor) {
    scale.push_back(s);
    sigma2.push_back(s * s);
    inv_sigma2.push_back(1 / (s * s));
  }
}

int ScalePyramid::predict_level(float d_max, float distance) const {
  // The first level whose scale reaches d_max / distance: ceil of the logarithm, without taking one.
  const float ratio = d_max / distance;
  int level = 0;
  while (level + 1 < levels && scale[static_cast<size_t>(level)] < ratio) ++level;
  return level;
}

void Features::start(size_t room) {
  for (auto* array : {&x, &y, &raw_x, &raw_y, &angle, &u_right, &depth}) {
    array->clear();
    array->reserve(room);
  }
  level.clear();
  level.reserve(room);
  descriptor.clear();
  descriptor.reserve(room);
  grid.indices.reserve(room);
  grid.offsets.reserve(static_cast<size_t>(FeatureGrid::kColumns) * FeatureGrid::kRows + 1);
}

void FeatureGrid::build(const ImageBounds& image_bounds, const AlignedVector<float>& x, const AlignedVector<float>& y) {
  assert(x.size() <= kMaxFeatures);
  bounds = image_bounds;
  inv_cell_width = kColumns / (bounds.max_x - bounds.min_x);
  inv_cell_height = kRows / (bounds.max_y - bounds.min_y);
  const auto cell_of = [&](size_t i) {
    const int c = std::clamp(static_cast<int>((x[i] - bounds.min_x) * inv_cell_width), 0, kColumns - 1);
    const int r = std::clamp(static_cast<int>((y[i] - bounds.min_y) * inv_cell_height), 0, kRows - 1);
    return static_cast<size_t>(r) * kColumns + static_cast<size_t>(c);
  };
  offsets.assign(static_cast<size_t>(kColumns) * kRows + 1, 0);
  for (size_t i = 0; i < x.size(); ++i) ++offsets[cell_of(i) + 1];
  for (size_t c = 1; c < offsets.size(); ++c) offsets[c] = static_cast<uint16_t>(offsets[c] + offsets[c - 1]);
  indices.resize(x.size());
  // A cell's offset walks from its first index to its end, where the next cell's begins.
  for (size_t i = 0; i < x.size(); ++i) indices[offsets[cell_of(i)]++] = static_cast<uint16_t>(i);
  std::copy_backward(offsets.begin(), offsets.end() - 1, offsets.end());
  offsets[0] = 0;
}

}  // namespace covis
