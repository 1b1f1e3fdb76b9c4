// SPDX-License-Identifier: Apache-2.0
#include "covis/features/depth_outlines.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "covis/features/depth_lookup.h"

namespace covis {
namespace {

constexpr int kCells = 80;                // side by side
constexpr size_t kFrames = 5;             // looked at for an answer
constexpr int kHere = 3;                  // cells that count as no displacement
constexpr int kLeastX = 8, kLeastY = 6;   // cells: a displacement is more than either
constexpr int kMostX = 24, kMostY = 18;   // cells: those looked at
constexpr int kOff = 2;                   // cells by which a mirrored or scaled image may be off
constexpr int kLanes = 8;                 // sums of a register
constexpr int kMargin = kMostX + kLanes;  // cells around the edges
constexpr float kLeastStep = 1.13f;       // factor of depth across two cells that makes an outline
constexpr int kBeside = 3;                // cells from an outline to where the slant of the surfaces is seen
constexpr float kTimesSlope = 2;
constexpr size_t kMostOutlines = 256;  // a frame has; sums stay below 2^15
constexpr int32_t kMostEdge = 127;
constexpr int32_t kUnit = 8;          // a grey level
constexpr int32_t kGrey = 4 * kUnit;  // gradients that noise makes
constexpr int kSurroundings = 5;      // cells to each side

// A depth camera's view may be narrower or wider than the image's. Nearer to 1 the middle of the image fits as it is.
constexpr std::array kScales{0.5f, 0.56f, 0.63f, 0.71f, 0.79f, 1.26f, 1.41f, 1.59f, 1.78f, 2.0f};

constexpr double kNoFit = 3;
constexpr int kManyOutlines = 300;

// A step of depth from one side of a cell to the other. Surfaces at a slant have such steps everywhere; their inverse
// depth changes evenly, and no more here than beside it.
bool is_outline(const float* at, int off) {
  const float a = at[-off], b = at[off], near = std::min(a, b), far = std::max(a, b);
  if (!(near > 0) || !(far > kLeastStep * near)) return false;
  const float before = at[-kBeside * off], after = at[kBeside * off];
  if (!(before > 0) || !(after > 0)) return false;
  const float step = 1 / near - 1 / far;
  return step > kTimesSlope * std::abs(1 / a - 1 / before) && step > kTimesSlope * std::abs(1 / b - 1 / after);
}

// 128 log2(value) and a constant, to a tenth of an octave: the bits of a float are nearly its logarithm.
int32_t logarithm(int32_t value) { return std::bit_cast<int32_t>(static_cast<float>(value)) >> 16; }

}  // namespace

bool OutlineFit::Place::is_at(const Place& other) const {
  return scale_x == other.scale_x && scale_y == other.scale_y && std::abs(x - other.x) <= 1 &&
         std::abs(y - other.y) <= 1;
}

bool OutlineFit::Place::has_another_size() const { return std::abs(scale_x) != 1 || std::abs(scale_y) != 1; }

bool OutlineFit::Place::is_about_as_large(const Place& other) const {
  constexpr float kStep = 1.3f;  // factor
  return std::max(scale_x, other.scale_x) <= kStep * std::min(scale_x, other.scale_x);
}

bool OutlineFit::tells_much() const { return outlines >= kManyOutlines; }

double OutlineFit::ratio() const { return elsewhere / std::max(here, kNoFit); }

std::optional<OutlineFit> DepthOutlines::add(ImageView<const uint8_t> image, ImageView<const float> depth) {
  if (displacements_.empty()) start(image);
  find_outlines(depth);
  average(image);
  find_edges();
  for (Displacements& all : displacements_) fit(all);
  if (++frames_ % kFrames != 0) return std::nullopt;
  return answer();
}

void DepthOutlines::start(ImageView<const uint8_t> image) {
  block_ = std::max(1, image.width / kCells);
  width_ = image.width / block_;
  height_ = image.height / block_;
  stride_ = width_ + 2 * kMargin;
  const auto cells = static_cast<size_t>(width_ * height_);
  depth_.resize(cells);
  for (std::vector<int32_t>* plane : {&grey_, &gradient_, &along_rows_}) plane->resize(cells);
  columns_.resize(static_cast<size_t>(width_ * block_));
  around_.resize(static_cast<size_t>(width_));
  edge_.resize(static_cast<size_t>(stride_ * (height_ + 2 * kMargin)));
  outlines_.reserve(cells);
  const auto add = [this](float scale_x, float scale_y, int reach_x, int reach_y) {
    Displacements all{scale_x, scale_y, reach_x, reach_y, (2 * reach_x / kLanes + 1) * kLanes, {}, {}};
    all.total.resize(static_cast<size_t>(all.columns * (2 * reach_y + 1)));
    all.sums.resize(all.total.size());
    displacements_.push_back(std::move(all));
  };
  add(1, 1, kMostX, kMostY);
  for (const auto& [x, y] : {std::pair(-1.0f, 1.0f), std::pair(1.0f, -1.0f), std::pair(-1.0f, -1.0f)})
    add(x, y, kOff, kOff);
  for (const float scale : kScales) add(scale, scale, kOff, kOff);
}

void DepthOutlines::find_outlines(ImageView<const float> depth) {
  for (int y = 0; y < height_; ++y) {
    const float* row = depth.row(y * block_ + block_ / 2) + block_ / 2;
    for (int x = 0; x < width_; ++x) {
      const float z = row[x * block_];
      depth_[static_cast<size_t>(y * width_ + x)] = is_depth(z) ? z : 0;
    }
  }
  outlines_.clear();
  for (int y = kBeside; y + kBeside < height_; ++y) {
    for (int x = kBeside; x + kBeside < width_; ++x) {
      const float* at = depth_.data() + y * width_ + x;
      if (is_outline(at, 1) || is_outline(at, width_)) outlines_.push_back({x, y});
    }
  }
  counted_ += static_cast<int>(outlines_.size());
  const size_t every = (outlines_.size() + kMostOutlines - 1) / kMostOutlines;
  if (every < 2) return;
  size_t kept = 0;
  for (size_t k = 0; k < outlines_.size(); k += every) outlines_[kept++] = outlines_[k];
  outlines_.resize(kept);
}

// Every second row and column of a cell.
void DepthOutlines::average(ImageView<const uint8_t> image) {
  const int count = (block_ + 1) / 2;
  const int32_t pixels = count * count;
  for (int y = 0; y < height_; ++y) {
    std::fill(columns_.begin(), columns_.end(), uint16_t{0});
    for (int v = 0; v < block_; v += 2) {
      const uint8_t* row = image.row(y * block_ + v);
      uint16_t* sums = columns_.data();
      for (int x = 0; x < width_ * block_; ++x) sums[x] = static_cast<uint16_t>(sums[x] + row[x]);
    }
    const uint16_t* sums = columns_.data();
    for (int x = 0; x < width_; ++x, sums += block_) {
      int32_t sum = 0;
      for (int u = 0; u < block_; u += 2) sum += sums[u];
      grey_[static_cast<size_t>(y * width_ + x)] = kUnit * sum / pixels;
    }
  }
}

// The logarithm of the gradient less its mean around, so that places full of texture count no more than others.
void DepthOutlines::find_edges() {
  for (int y = 0; y < height_; ++y) {
    const int32_t* above = grey_.data() + std::max(0, y - 1) * width_;
    const int32_t* row = grey_.data() + y * width_;
    const int32_t* below = grey_.data() + std::min(height_ - 1, y + 1) * width_;
    int32_t* out = gradient_.data() + y * width_;
    const auto gradient = [&](int x, int left, int right) {
      const int32_t gx = row[right] - row[left], gy = below[x] - above[x];
      return logarithm(gx * gx + gy * gy + kGrey * kGrey);
    };
    for (int x = 1; x + 1 < width_; ++x) out[x] = gradient(x, x - 1, x + 1);
    out[0] = gradient(0, 0, std::min(1, width_ - 1));
    out[width_ - 1] = gradient(width_ - 1, std::max(0, width_ - 2), width_ - 1);
    int32_t sum = (kSurroundings + 1) * out[0];
    for (int x = 1; x <= kSurroundings; ++x) sum += out[std::min(x, width_ - 1)];
    int32_t* sums = along_rows_.data() + y * width_;
    for (int x = 0; x < width_; ++x) {
      sums[x] = sum;
      sum += out[std::min(x + 1 + kSurroundings, width_ - 1)] - out[std::max(x - kSurroundings, 0)];
    }
  }
  const auto sums_of = [this](int y) { return along_rows_.data() + std::clamp(y, 0, height_ - 1) * width_; };
  std::fill(around_.begin(), around_.end(), 0);
  for (int y = -kSurroundings; y <= kSurroundings; ++y) {
    const int32_t* sums = sums_of(y);
    for (int x = 0; x < width_; ++x) around_[static_cast<size_t>(x)] += sums[x];
  }
  constexpr int32_t kSide = 2 * kSurroundings + 1;
  int64_t squares = 0;
  for (int y = 0; y < height_; ++y) {
    const int32_t* gradient = gradient_.data() + y * width_;
    const int32_t *added = sums_of(y + 1 + kSurroundings), *left = sums_of(y - kSurroundings);
    int16_t* edge = edge_.data() + (y + kMargin) * stride_ + kMargin;
    int32_t* around = around_.data();
    int32_t of_row = 0;
    for (int x = 0; x < width_; ++x) {
      const int32_t value = std::clamp((kSide * kSide * gradient[x] - around[x]) >> 10, -kMostEdge, kMostEdge);
      edge[x] = static_cast<int16_t>(value);
      of_row += value * value;
      around[x] += added[x] - left[x];
    }
    squares += of_row;
  }
  variance_ += static_cast<double>(outlines_.size()) * static_cast<double>(squares) / (width_ * height_);
}

void DepthOutlines::fit(Displacements& all) {
  std::fill(all.sums.begin(), all.sums.end(), int16_t{0});
  const auto scaled = [](int cell, float scale, int cells) {
    const float middle = 0.5f * static_cast<float>(cells - 1);
    return static_cast<int>(std::lround(middle + scale * (static_cast<float>(cell) - middle)));
  };
  for (const Outline& o : outlines_) {
    const int x = scaled(o.x, all.scale_x, width_), y = scaled(o.y, all.scale_y, height_);
    if (x < 0 || x >= width_ || y < 0 || y >= height_) continue;
    const int16_t* edge = edge_.data() + (y + kMargin - all.reach_y) * stride_ + x + kMargin - all.reach_x;
    int16_t* __restrict sums = all.sums.data();
    for (int dy = -all.reach_y; dy <= all.reach_y; ++dy, edge += stride_, sums += all.columns) {
      for (int first = 0; first < all.columns; first += kLanes) {
        for (int k = first; k < first + kLanes; ++k) sums[k] = static_cast<int16_t>(sums[k] + edge[k]);
      }
    }
  }
  for (size_t k = 0; k < all.sums.size(); ++k) all.total[k] += all.sums[k];
}

// True when cells have changed by half of what they differ from their mean: another view changes them by 1.4 times
// that.
bool DepthOutlines::is_new_view() {
  constexpr int kShare = 2;
  const auto cells = static_cast<int64_t>(grey_.size());
  const int64_t mean = std::accumulate(grey_.begin(), grey_.end(), int64_t{0}) / std::max<int64_t>(1, cells);
  int64_t change = 0, contrast = 0;
  for (size_t k = 0; k < viewed_.size(); ++k) {
    change += std::abs(grey_[k] - viewed_[k]);
    contrast += std::abs(grey_[k] - mean);
  }
  if (!viewed_.empty() && kShare * change < contrast) return false;
  viewed_ = grey_;
  return true;
}

OutlineFit DepthOutlines::answer() {
  OutlineFit found;
  found.new_view = is_new_view();
  const double sigma = std::sqrt(std::max(1.0, variance_));
  for (Displacements& all : displacements_) {
    const bool changed = all.scale_x != 1 || all.scale_y != 1;
    for (int dy = -all.reach_y; dy <= all.reach_y; ++dy) {
      const int32_t* total = all.total.data() + (dy + all.reach_y) * all.columns + all.reach_x;
      for (int dx = -all.reach_x; dx <= all.reach_x; ++dx) {
        const int far_x = std::abs(dx), far_y = std::abs(dy);
        const bool here = !changed && far_x <= kHere && far_y <= kHere;
        const bool elsewhere = changed || far_x > kLeastX || far_y > kLeastY;
        if (here) found.here = std::max(found.here, total[dx] / sigma);
        if (!elsewhere || total[dx] / sigma <= found.elsewhere) continue;
        found.elsewhere = total[dx] / sigma;
        found.place = {all.scale_x, all.scale_y, dx, dy};
      }
    }
    std::fill(all.total.begin(), all.total.end(), 0);
  }
  variance_ = 0;
  found.outlines = std::exchange(counted_, 0);
  return found;
}

}  // namespace covis
