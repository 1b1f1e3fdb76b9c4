// SPDX-License-Identifier: Apache-2.0
#include "covis/features/frozen_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "covis/features/depth_lookup.h"

namespace covis {
namespace {

constexpr int kStep = 16;                   // pixels and rows from one depth looked at to the next
constexpr int kBlocks = 16;                 // side by side, and as many above each other
constexpr int kLeastEqual = 15;             // cameras whose depth is slower than their images repeat it a few times
constexpr int kLeastDepths = 20;            // depths without which a depth image says nothing
constexpr size_t kLeastShare = 4;           // one pixel in so many has a depth
constexpr int32_t kSixteenth = 16;          // units of a grey level
constexpr int32_t kMoved = 2 * kSixteenth;  // mean change of the blocks that noise does not make

}  // namespace

int FrozenDepth::add(ImageView<const uint8_t> image, ImageView<const float> depth) {
  if (!equals_last(depth)) {
    equal_ = 1;
    return 0;
  }
  average(image);
  if (++equal_ == 2) first_ = grey_;
  if (equal_ < kLeastEqual) return 0;
  int32_t brighter = 0, change = 0;
  for (size_t k = 0; k < grey_.size(); ++k) brighter += grey_[k] - first_[k];
  brighter /= static_cast<int32_t>(grey_.size());
  for (size_t k = 0; k < grey_.size(); ++k) change += std::abs(grey_[k] - first_[k] - brighter);
  return change > static_cast<int32_t>(grey_.size()) * kMoved ? equal_ : 0;
}

// Keeps the depths that it looked at.
bool FrozenDepth::equals_last(ImageView<const float> depth) {
  const size_t count =
      static_cast<size_t>((depth.width + kStep - 1) / kStep) * static_cast<size_t>((depth.height + kStep - 1) / kStep);
  bool equal = depth_.size() == count;
  depth_.resize(count);
  float* kept = depth_.data();
  int measured = 0;
  for (int y = 0; y < depth.height; y += kStep) {
    for (int x = 0; x < depth.width; x += kStep, ++kept) {
      const float z = depth.row(y)[x];
      const float now = is_depth(z) ? z : 0;
      measured += now > 0;
      equal &= *kept == now;
      *kept = now;
    }
  }
  return equal && measured >= kLeastDepths && kLeastShare * static_cast<size_t>(measured) >= count;
}

// Every fourth pixel of every fourth row.
void FrozenDepth::average(ImageView<const uint8_t> image) {
  constexpr int kEvery = 4;
  grey_.resize(static_cast<size_t>(kBlocks * kBlocks));
  for (int v = 0; v < kBlocks; ++v) {
    const int top = v * image.height / kBlocks, bottom = (v + 1) * image.height / kBlocks;
    for (int u = 0; u < kBlocks; ++u) {
      const int left = u * image.width / kBlocks, right = (u + 1) * image.width / kBlocks;
      int32_t sum = 0, pixels = 0;
      for (int y = top; y < bottom; y += kEvery) {
        const uint8_t* row = image.row(y);
        for (int x = left; x < right; x += kEvery, ++pixels) sum += row[x];
      }
      grey_[static_cast<size_t>(v * kBlocks + u)] = kSixteenth * sum / std::max(1, pixels);
    }
  }
}

}  // namespace covis
