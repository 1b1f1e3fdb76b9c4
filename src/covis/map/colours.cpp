// SPDX-License-Identifier: Apache-2.0
#include "covis/map/colours.h"

#include <algorithm>
#include <cmath>

namespace covis {

ColoursPtr colours_at(const Features& features, const ColourImage& image) {
  auto colours = std::make_shared<std::vector<Colour>>();
  const auto count = static_cast<size_t>(features.size());
  colours->reserve(count);
  const auto &u = features.image_x(), &v = features.image_y();
  for (size_t i = 0; i < count; ++i) {
    const long x = std::clamp(std::lround(u[i]), 0L, image.width - 1L);
    const long y = std::clamp(std::lround(v[i]), 0L, image.height - 1L);
    const uint8_t* p = image.data + y * image.stride + 3 * x;
    colours->push_back(image.order == ColourOrder::rgb ? Colour{p[0], p[1], p[2]} : Colour{p[2], p[1], p[0]});
  }
  return colours;
}

void MeanColours::add(size_t index, const Colour& colour) {
  Sum& sum = sums_[index];
  sum.red += colour[0];
  sum.green += colour[1];
  sum.blue += colour[2];
  ++sum.count;
}

Colour MeanColours::mean(size_t index) const {
  const Sum& sum = sums_[index];
  if (sum.count == 0) return kNoColour;
  const auto part = [&](uint32_t all) { return static_cast<uint8_t>((all + sum.count / 2) / sum.count); };
  return {part(sum.red), part(sum.green), part(sum.blue)};
}

}  // namespace covis
