// SPDX-License-Identifier: Apache-2.0
#include "covis/features/depth_outlines.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace covis {
namespace {

constexpr int kCells = 80;                          // side by side
constexpr size_t kEvery = 2, kFrames = 10;          // frames between those looked at; of those for an answer
constexpr int kHere = 3;                            // cells that count as no displacement
constexpr int kLeastX = 8, kLeastY = 6;             // cells: a displacement is more than either
constexpr int kMostX = 24, kMostY = 18, kStep = 2;  // cells: those looked at
constexpr int kFlipped = 2;                         // cells by which a mirrored image may be off
constexpr float kLeastStep = 1.13f;  // factor of depth across two cells that makes an outline
constexpr float kMostWeight = 0.5f;  // of an outline: its factor's logarithm
constexpr float kGrey = 4;           // grey levels: gradients that noise makes
constexpr int kSurroundings = 5;     // cells to each side

constexpr double kTimesBetter = 2, kLeastFit = 12, kNoFit = 3;

// The depth of a cell: the median of nine of its pixels; 0 where fewer than three have one.
float depth_of_cell(ImageView<const float> depth, int left, int top, int side) {
  std::array<float, 9> found{};
  size_t n = 0;
  for (const int v : {1, 3, 5}) {
    const float* row = depth.row(top + v * side / 6);
    for (const int u : {1, 3, 5}) {
      const float z = row[left + u * side / 6];
      if (z > 0 && std::isfinite(z)) found[n++] = z;
    }
  }
  if (n < 3) return 0;
  std::sort(found.begin(), found.begin() + static_cast<ptrdiff_t>(n));  // insertions: so few
  return found[n / 2];
}

}  // namespace

bool OutlineFit::is_displaced() const { return elsewhere > kLeastFit && ratio() > kTimesBetter; }

double OutlineFit::ratio() const { return elsewhere / std::max(here, kNoFit); }

std::optional<OutlineFit> DepthOutlines::add(ImageView<const uint8_t> image, ImageView<const float> depth) {
  if (frames_++ % kEvery != 0) return std::nullopt;
  if (displacements_.empty()) start(image);
  find_outlines(depth);
  find_edges(image);
  fit();
  if (++looked_at_ % kFrames != 0) return std::nullopt;
  return answer();
}

void DepthOutlines::start(ImageView<const uint8_t> image) {
  block_ = std::max(1, image.width / kCells);
  width_ = image.width / block_;
  height_ = image.height / block_;
  const auto cells = static_cast<size_t>(width_ * height_);
  for (std::vector<float>* plane : {&grey_, &depth_, &edge_, &mean_}) plane->resize(cells);
  outlines_.reserve(cells);
  for (int dy = -kHere; dy <= kHere; ++dy) {
    for (int dx = -kHere; dx <= kHere; ++dx) displacements_.push_back({.dx = dx, .dy = dy, .is_here = true});
  }
  for (int dy = -kMostY; dy <= kMostY; dy += kStep) {
    for (int dx = -kMostX; dx <= kMostX; dx += kStep) {
      if (std::abs(dx) > kLeastX || std::abs(dy) > kLeastY) displacements_.push_back({.dx = dx, .dy = dy});
    }
  }
  for (int dy = -kFlipped; dy <= kFlipped; ++dy) {
    for (int dx = -kFlipped; dx <= kFlipped; ++dx) {
      displacements_.push_back({.dx = dx, .dy = dy, .flip_x = true});
      displacements_.push_back({.dx = dx, .dy = dy, .flip_y = true});
      displacements_.push_back({.dx = dx, .dy = dy, .flip_x = true, .flip_y = true});
    }
  }
}

void DepthOutlines::find_outlines(ImageView<const float> depth) {
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      depth_[static_cast<size_t>(y * width_ + x)] = depth_of_cell(depth, x * block_, y * block_, block_);
    }
  }
  outlines_.clear();
  for (int y = 1; y + 1 < height_; ++y) {
    for (int x = 1; x + 1 < width_; ++x) {
      const int at = y * width_ + x;
      const auto step = [&](int off) {
        const auto [near, far] =
            std::minmax(depth_[static_cast<size_t>(at - off)], depth_[static_cast<size_t>(at + off)]);
        return near > 0 ? far / near : 0;
      };
      const float greatest = std::max(step(1), step(width_));
      if (greatest > kLeastStep) outlines_.push_back({x, y, std::min(std::log(greatest), kMostWeight)});
    }
  }
}

// The logarithm of the gradient less its mean around, so that places full of texture count no more than others.
void DepthOutlines::find_edges(ImageView<const uint8_t> image) {
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      int sum = 0;
      for (int v = 0; v < block_; ++v) {
        const uint8_t* row = image.row(y * block_ + v) + x * block_;
        for (int u = 0; u < block_; ++u) sum += row[u];
      }
      grey_[static_cast<size_t>(y * width_ + x)] = static_cast<float>(sum) / static_cast<float>(block_ * block_);
    }
  }
  const auto clamped = [](const std::vector<float>& plane, int width, int height, int x, int y) {
    return plane[static_cast<size_t>(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
  };
  const auto gradient = [&](int x, int y) {
    const int u = std::clamp(x, 1, width_ - 2), v = std::clamp(y, 1, height_ - 2);
    const float gx = clamped(grey_, width_, height_, u + 1, v) - clamped(grey_, width_, height_, u - 1, v);
    const float gy = clamped(grey_, width_, height_, u, v + 1) - clamped(grey_, width_, height_, u, v - 1);
    return std::log(std::sqrt(gx * gx + gy * gy) + kGrey);
  };
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) edge_[static_cast<size_t>(y * width_ + x)] = gradient(x, y);
  }
  constexpr float kShare = 1.0f / (2 * kSurroundings + 1);
  for (int y = 0; y < height_; ++y) {  // along rows, into mean_; grey_ is used no more
    for (int x = 0; x < width_; ++x) {
      float sum = 0;
      for (int k = -kSurroundings; k <= kSurroundings; ++k) sum += clamped(edge_, width_, height_, x + k, y);
      mean_[static_cast<size_t>(y * width_ + x)] = kShare * sum;
    }
  }
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      float sum = 0;
      for (int k = -kSurroundings; k <= kSurroundings; ++k) sum += clamped(mean_, width_, height_, x, y + k);
      grey_[static_cast<size_t>(y * width_ + x)] = edge_[static_cast<size_t>(y * width_ + x)] - kShare * sum;
    }
  }
  edge_.swap(grey_);
}

void DepthOutlines::fit() {
  for (Displacement& d : displacements_) {
    double sum = 0, squares = 0;
    for (const Outline& o : outlines_) {
      const int x = (d.flip_x ? width_ - 1 - o.x : o.x) + d.dx, y = (d.flip_y ? height_ - 1 - o.y : o.y) + d.dy;
      if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
      const float product = o.weight * edge_[static_cast<size_t>(y * width_ + x)];
      sum += static_cast<double>(product);
      squares += static_cast<double>(product * product);
    }
    d.sum += sum;
    d.squares += squares;
  }
}

OutlineFit DepthOutlines::answer() {
  OutlineFit found;
  for (Displacement& d : displacements_) {
    if (d.squares > 0) {
      double& best = d.is_here ? found.here : found.elsewhere;
      best = std::max(best, d.sum / std::sqrt(d.squares));
    }
    d.sum = d.squares = 0;
  }
  return found;
}

}  // namespace covis
