// SPDX-License-Identifier: Apache-2.0
#include "covis/features/extractor.h"

#include <algorithm>
#include <cmath>

#include "covis/features/orb.h"

namespace covis {
namespace {

constexpr int kCellSize = 30;

// Shares of the levels: proportional to factor^-l, the last level what is left. What a level can't fill goes to the others in
// proportion, finest first.
void share_budget(int total, double factor, const std::vector<int>& available, std::vector<int>& share) {
  const size_t levels = available.size();
  share.assign(levels, 0);
  double weight = 0;
  for (size_t l = 0; l < levels; ++l) weight += std::pow(factor, -static_cast<double>(l));
  int given = 0;
  for (size_t l = 0; l + 1 < levels; ++l) {
    share[l] = static_cast<int>(std::lround(total * std::pow(factor, -static_cast<double>(l)) / weight));
    given += share[l];
  }
  share[levels - 1] = std::max(0, total - given);
  for (int round = 0; round < 4; ++round) {
    int missing = 0, room = 0;
    for (size_t l = 0; l < levels; ++l) {
      if (share[l] > available[l]) {
        missing += share[l] - available[l];
        share[l] = available[l];
      } else {
        room += available[l] - share[l];
      }
    }
    if (missing == 0 || room == 0) break;
    int left = std::min(missing, room);
    for (size_t l = 0; l < levels && left > 0; ++l) {
      const int spare = available[l] - share[l];
      const int more = std::min({spare, left, static_cast<int>(std::ceil(static_cast<double>(missing) * spare / room))});
      share[l] += more;
      left -= more;
    }
  }
}

}  // namespace

void KeyPoints::clear() {
  for (auto* array : {&x, &y, &angle}) array->clear();
  level.clear();
  descriptor.clear();
}

OrbExtractor::OrbExtractor(const OrbOptions& options)
    : options_(options),
      pyramid_(std::make_shared<ScalePyramid>(options.levels, static_cast<float>(options.scale_factor))),
      levels_(static_cast<size_t>(options.levels)),
      stretch_(levels_.size()),
      resizers_(levels_.size()),
      available_(levels_.size()),
      corners_(levels_.size()),
      kept_(levels_.size()) {}

const KeyPoints& OrbExtractor::extract(ImageView<const uint8_t> image) {
  image_ = image;
  key_points_.clear();
  for (size_t l = 0; l < levels_.size(); ++l) {
    if (l > 0) {
      const int width = static_cast<int>(std::lround(static_cast<float>(image.width) / pyramid_->scale[l]));
      const int height = static_cast<int>(std::lround(static_cast<float>(image.height) / pyramid_->scale[l]));
      levels_[l].resize(std::max(1, width), std::max(1, height));
      resizers_[l].resize(level(static_cast<int>(l) - 1), levels_[l].view());
    }
    const ImageView<const uint8_t> at = level(static_cast<int>(l));
    stretch_[l] = {static_cast<float>(image.width) / static_cast<float>(at.width),
                   static_cast<float>(image.height) / static_cast<float>(at.height)};
    detector_.detect(level(static_cast<int>(l)), kEdgeBorder, kCellSize, options_.fast_threshold, options_.fast_threshold_low,
                     corners_[l]);
    available_[l] = static_cast<int>(corners_[l].size());
  }
  share_budget(options_.features, options_.scale_factor, available_, share_);
  for (size_t l = 0; l < levels_.size(); ++l) {
    const ImageView<const uint8_t> from = level(static_cast<int>(l));
    quadtree_.distribute(corners_[l], kEdgeBorder, kEdgeBorder, from.width - kEdgeBorder, from.height - kEdgeBorder, share_[l],
                         kept_[l]);
    if (kept_[l].empty()) continue;
    blur_.apply(from, blurred_);
    for (const Corner& c : kept_[l]) {
      const float angle = orientation(from.row(c.y) + c.x, from.stride);
      const Eigen::Vector2f place = to_image(static_cast<int>(l), static_cast<float>(c.x) + (options_.subpixel ? c.dx : 0),
                                             static_cast<float>(c.y) + (options_.subpixel ? c.dy : 0));
      key_points_.x.push_back(place.x());
      key_points_.y.push_back(place.y());
      key_points_.angle.push_back(angle);
      key_points_.level.push_back(static_cast<uint8_t>(l));
      key_points_.descriptor.push_back(describe(blurred_.row(c.y) + c.x, blurred_.stride(), angle));
    }
  }
  return key_points_;
}

}  // namespace covis
