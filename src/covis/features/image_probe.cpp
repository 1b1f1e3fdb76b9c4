// SPDX-License-Identifier: Apache-2.0
#include "covis/features/image_probe.h"

#include <algorithm>
#include <cmath>

#include "covis/features/extractor.h"
#include "covis/features/orb.h"

namespace covis {

std::optional<int> ImageProbe::distance(const Descriptor& descriptor, const Expected& point,
                                        const Pinhole& refined) const {
  constexpr int kAround = 1;  // pixels of the level
  const double factor = extractor_.pyramid()->factor;
  const int level = static_cast<int>(std::lround(std::log(point.scale) / std::log(factor)));
  if (level < 0 || level >= extractor_.levels()) return std::nullopt;
  const ImageView<const uint8_t> image = extractor_.blurred(level);
  const auto pixel = image.empty() ? std::nullopt : image_pixel(camera_, refined, point.p_c);
  if (!pixel) return std::nullopt;
  const Eigen::Vector2f at = extractor_.to_level(level, static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
  constexpr float kBorder = kEdgeBorder + kAround;
  const Eigen::Vector2f last(static_cast<float>(image.width) - 1, static_cast<float>(image.height) - 1);
  if (!((at.array() >= kBorder).all() && ((last - at).array() >= kBorder + 1).all())) return std::nullopt;
  const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
  const TurnedPattern pattern(point.angle, image.stride);
  int least = kHammingBeyond;
  for (int row = y - kAround; row <= y + kAround; ++row) {
    for (int column = x - kAround; column <= x + kAround; ++column)
      least = std::min(least, hamming(descriptor, pattern.describe(image.row(row) + column)));
  }
  return least;
}

}  // namespace covis
