// SPDX-License-Identifier: Apache-2.0
#include "covis/features/features.h"

#include <cassert>

namespace covis {

ScalePyramid::ScalePyramid(int level_count, float scale_factor, float base_scale)
    : levels(level_count), factor(scale_factor), base(base_scale) {
  float s = base;
  for (int l = 0; l < levels; ++l, s *= factor) {
    scale.push_back(s);
    sigma2.push_back(s * s);
    inv_sigma2.push_back(1 / (s * s));
  }
}

int ScalePyramid::predict_level(float d_max, float distance) const {
  // Finds the first level whose scale reaches d_max / distance: the ceil of the logarithm without computing one.
  const float ratio = d_max / distance;
  int level = 0;
  while (level + 1 < levels && scale[static_cast<size_t>(level)] < ratio) ++level;
  return level;
}

void Features::start(size_t room, RawPixels raw) {
  for (auto* array : {&x, &y, &angle, &u_right, &depth}) {
    array->clear();
    array->reserve(room);
  }
  for (auto* array : {&raw_x, &raw_y}) {
    array->clear();
    if (raw == RawPixels::different) array->reserve(room);
  }
  level.clear();
  level.reserve(room);
  descriptor.clear();
  descriptor.reserve(room);
  grid.indices.reserve(room);
  grid.offsets.reserve(std::min(room, FeatureGrid::kCells) + 1);
}

Eigen::Vector2d Features::pinhole_pixel(size_t i) const {
  const Eigen::Vector2d image(image_x()[i], image_y()[i]);
  return lens ? lens->undistort(image).value_or(image) : image;
}

std::shared_ptr<Features> Features::for_key_frame() const {
  auto copy = std::make_shared<Features>(*this);
  copy->small = {};
  if (patches) copy->patches = std::make_shared<Patches>(*patches);
  return copy;
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
  std::array<uint16_t, kCells> next{};  // count of each cell, then the position of its next index
  for (size_t i = 0; i < x.size(); ++i) ++next[cell_of(i)];
  // Every cell writes its offset and the next filled cell overwrites that of an empty one: cheaper than a branch.
  offsets.resize(std::min(x.size(), kCells) + 1);
  size_t cells = 0;
  uint16_t total = 0;
  for (size_t r = 0; r < kRows; ++r) {
    before[r] = static_cast<uint16_t>(cells);
    uint64_t bits = 0;
    for (size_t c = 0; c < kColumns; ++c) {
      uint16_t& cell = next[r * kColumns + c];
      const uint16_t count = cell;
      cell = offsets[cells] = total;
      total = static_cast<uint16_t>(total + count);
      bits |= uint64_t{count > 0} << c;
      cells += count > 0;
    }
    filled[r] = bits;
  }
  offsets[cells] = total;
  offsets.resize(cells + 1);
  indices.resize(x.size());
  for (size_t i = 0; i < x.size(); ++i) indices[next[cell_of(i)]++] = static_cast<uint16_t>(i);
}

}  // namespace covis
