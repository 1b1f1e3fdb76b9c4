// SPDX-License-Identifier: Apache-2.0
#include "covis/features/extractor.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "covis/features/gradients.h"
#include "covis/features/orb.h"

namespace covis {
namespace {

constexpr int kCellSize = 30;

// A level has room for one keypoint in so many of its own pixels inside the border: more of them would show much the
// same patches. While a greater budget than OrbOptions::features is wanted, there is as much more room.
constexpr double kPixelsOfKeypoint = 144;

int inside(int side) { return std::max(0, side - 2 * kEdgeBorder); }

// Gives `more` keypoints to levels that have fewer than `most`, in proportion to what they lack, finest first.
void add_shares(int more, const std::vector<int>& most, std::vector<int>& share) {
  int room = 0;
  for (size_t l = 0; l < share.size(); ++l) room += std::max(0, most[l] - share[l]);
  if (room == 0) return;
  const int all = std::min(more, room);
  int left = all;
  for (size_t l = 0; l < share.size(); ++l) {
    const int spare = std::max(0, most[l] - share[l]);
    const int part = std::min({spare, left, static_cast<int>(std::ceil(static_cast<double>(all) * spare / room))});
    share[l] += part;
    left -= part;
  }
}

// Feature budget of the levels: proportional to factor^-l, and the remainder for the last level. What is more than a
// level has room for is given to others that have; what none has room for, to those that have corners (`available`).
void share_out(int total, double factor, const std::vector<int>& with_room, const std::vector<int>& available,
               std::vector<int>& share) {
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
  for (size_t l = 0; l < levels; ++l) share[l] = std::min(share[l], with_room[l]);
  for (const auto* most : {&with_room, &available}) {
    add_shares(std::max(0, total - std::accumulate(share.begin(), share.end(), 0)), *most, share);
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

int keypoint_room(const OrbOptions& options, int width, int height) {
  double room = 0;
  for (int l = 0; l < pyramid_levels(options, width, height); ++l) {
    const double scale = std::pow(options.scale_factor, l);
    const auto side = [&](int whole) { return inside(static_cast<int>(std::lround(whole / scale))); };
    room += side(width) * static_cast<double>(side(height)) / kPixelsOfKeypoint;
  }
  return static_cast<int>(std::min(room, 1e9));
}

OrbExtractor::OrbExtractor(const OrbOptions& options, double edge_ratio)
    : options_(options),
      budget_(options.features),
      edge_ratio_(edge_ratio),
      levels_(static_cast<size_t>(options.levels > 0 ? options.levels : kFewestLevels)),
      pyramid_(std::make_shared<ScalePyramid>(levels(), static_cast<float>(options.scale_factor))),
      available_(levels_.size()),
      with_room_(levels_.size()) {}

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
  const int low = std::min(options_.fast_threshold_low, options_.fast_threshold);
  level.detector.detect(level.view, kEdgeBorder, kCellSize, options_.fast_threshold, low, level.corners);
  if (edge_ratio_ > 0) leave_out_edges(level.view, edge_ratio_, level.corners);
}

void OrbExtractor::share_budget() {
  const double density = budget_ / (kPixelsOfKeypoint * options_.features);
  for (size_t l = 0; l < levels_.size(); ++l) {
    available_[l] = static_cast<int>(levels_[l].corners.size());
    const ImageView<const uint8_t> view = levels_[l].view;
    with_room_[l] = std::min(available_[l], static_cast<int>(density * inside(view.width) * inside(view.height)));
  }
  share_out(budget_, options_.scale_factor, with_room_, available_, share_);
}

void OrbExtractor::describe(int l) {
  Level& level = levels_[static_cast<size_t>(l)];
  const ImageView<const uint8_t> from = level.view;
  KeyPoints& points = level.keypoints;
  points.clear();
  points.reserve(static_cast<size_t>(budget_) + 3);  // memory pages are used only when filled
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
