// SPDX-License-Identifier: Apache-2.0
#include "covis/features/extractor.h"

#include <algorithm>
#include <cmath>

#include "covis/features/gradients.h"
#include "covis/features/orb.h"

namespace covis {
namespace {

constexpr int kCellSize = 30;

// Feature budget of the levels: proportional to factor^-l, and the remainder for the last level. The budget that a
// level cannot fill is given to the others in proportion, finest first.
void share_out(int total, double factor, const std::vector<int>& available, std::vector<int>& share) {
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
      const int more =
          std::min({spare, left, static_cast<int>(std::ceil(static_cast<double>(missing) * spare / room))});
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

void KeyPoints::reserve(size_t n) {
  for (auto* array : {&x, &y, &angle}) array->reserve(n);
  level.reserve(n);
  descriptor.reserve(n);
}

void KeyPoints::append(const KeyPoints& more) {
  const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  add(x, more.x);
  add(y, more.y);
  add(angle, more.angle);
  add(level, more.level);
  add(descriptor, more.descriptor);
}

OrbExtractor::OrbExtractor(const OrbOptions& options, double edge_ratio)
    : options_(options),
      edge_ratio_(edge_ratio),
      pyramid_(std::make_shared<ScalePyramid>(options.levels, static_cast<float>(options.scale_factor))),
      levels_(static_cast<size_t>(options.levels)),
      available_(levels_.size()) {}

const KeyPoints& OrbExtractor::extract(ImageView<const uint8_t> image) {
  start(image);
  for (int l = 0; l < levels(); ++l) detect(l);
  share_budget();
  for (int l = 0; l < levels(); ++l) describe(l);
  return finish();
}

void OrbExtractor::start(ImageView<const uint8_t> image) {
  for (size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    level.view = image;
    if (l > 0) {
      const int width = static_cast<int>(std::lround(static_cast<float>(image.width) / pyramid_->scale[l]));
      const int height = static_cast<int>(std::lround(static_cast<float>(image.height) / pyramid_->scale[l]));
      level.image.resize(std::max(1, width), std::max(1, height));
      level.resizer.resize(levels_[l - 1].view, level.image.view());
      level.view = level.image.view();
    }
    level.stretch = {static_cast<float>(image.width) / static_cast<float>(level.view.width),
                     static_cast<float>(image.height) / static_cast<float>(level.view.height)};
  }
}

void OrbExtractor::detect(int l) {
  Level& level = levels_[static_cast<size_t>(l)];
  level.detector.detect(level.view, kEdgeBorder, kCellSize, options_.fast_threshold, options_.fast_threshold_low,
                        level.corners);
  if (edge_ratio_ > 0) leave_out_edges(level.view, edge_ratio_, level.corners);
}

void OrbExtractor::share_budget() {
  for (size_t l = 0; l < levels_.size(); ++l) available_[l] = static_cast<int>(levels_[l].corners.size());
  share_out(options_.features, options_.scale_factor, available_, share_);
}

void OrbExtractor::describe(int l) {
  Level& level = levels_[static_cast<size_t>(l)];
  const ImageView<const uint8_t> from = level.view;
  KeyPoints& points = level.keypoints;
  points.clear();
  points.reserve(static_cast<size_t>(options_.features) + 3);  // memory pages are used only when filled
  level.quadtree.distribute(level.corners, kEdgeBorder, kEdgeBorder, from.width - kEdgeBorder,
                            from.height - kEdgeBorder, share_[static_cast<size_t>(l)], level.kept);
  if (level.kept.empty()) return;
  level.blur.apply(from, level.blurred);
  for (const Corner& c : level.kept) {
    const float angle = orientation(from.row(c.y) + c.x, from.stride);
    const Eigen::Vector2f place = to_image(l, static_cast<float>(c.x) + (options_.subpixel ? c.dx() : 0),
                                           static_cast<float>(c.y) + (options_.subpixel ? c.dy() : 0));
    points.x.push_back(place.x());
    points.y.push_back(place.y());
    points.angle.push_back(angle);
    points.level.push_back(static_cast<uint8_t>(l));
    points.descriptor.push_back(covis::describe(level.blurred.row(c.y) + c.x, level.blurred.stride(), angle));
  }
}

const KeyPoints& OrbExtractor::finish() {
  keypoints_.clear();
  keypoints_.reserve(most_keypoints());
  for (const Level& level : levels_) keypoints_.append(level.keypoints);
  return keypoints_;
}

}  // namespace covis
