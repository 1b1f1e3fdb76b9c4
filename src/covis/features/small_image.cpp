// SPDX-License-Identifier: Apache-2.0
#include "covis/features/small_image.h"

#include <algorithm>
#include <cmath>

namespace covis {
namespace {

constexpr double kPixels = 1200;  // wanted: 40 x 30 of the usual aspect, as published
constexpr int kMaxBlock = 257;    // 257 rows of 255 still fit into 16 bits
constexpr int kBlurs = 2;         // binomial blurs of variance 1: sigma is 1.4 small pixels

}  // namespace

Pinhole SmallImage::camera(const Pinhole& of_image) const {
  const auto scale = [this](double focal) { return focal / block; };
  const auto place = [this](double at, int first) { return (at - first + 0.5) / block - 0.5; };
  return {scale(of_image.fx), scale(of_image.fy), place(of_image.cx, left), place(of_image.cy, top), 0};
}

void SmallImageMaker::make(ImageView<const uint8_t> image, SmallImage& small) {
  const double pixels = static_cast<double>(image.width) * image.height;
  small.block = std::clamp(static_cast<int>(std::lround(std::sqrt(pixels / kPixels))), 1,
                           std::min({kMaxBlock, image.width, image.height}));
  small.width = image.width / small.block;
  small.height = image.height / small.block;
  small.left = (image.width - small.width * small.block) / 2;
  small.top = (image.height - small.height * small.block) / 2;
  small.grey.resize(static_cast<size_t>(small.width) * static_cast<size_t>(small.height));
  average(image, small);
  for (int k = 0; k < kBlurs; ++k) blur(small);
}

void SmallImageMaker::average(ImageView<const uint8_t> image, SmallImage& small) {
  const int block = small.block, covered = small.width * block;
  const auto area = static_cast<uint32_t>(block * block);
  columns_.resize(static_cast<size_t>(covered));
  uint8_t* out = small.grey.data();
  for (int y = 0; y < small.height; ++y) {
    std::fill(columns_.begin(), columns_.end(), uint16_t{0});
    for (int k = 0; k < block; ++k) {
      const uint8_t* row = image.row(small.top + y * block + k) + small.left;
      uint16_t* sums = columns_.data();
      for (int x = 0; x < covered; ++x) sums[x] = static_cast<uint16_t>(sums[x] + row[x]);
    }
    for (int x = 0; x < small.width; ++x) {
      uint32_t sum = area / 2;
      for (int k = 0; k < block; ++k) sum += columns_[static_cast<size_t>(x * block + k)];
      *out++ = static_cast<uint8_t>(sum / area);
    }
  }
}

// One pass of the weights 1 4 6 4 1 along rows, and one along columns; the border is repeated.
void SmallImageMaker::blur(SmallImage& small) {
  const auto along = [this](uint8_t* first, int count, int step) {
    padded_.resize(static_cast<size_t>(count) + 4);
    for (int i = -2; i < count + 2; ++i)
      padded_[static_cast<size_t>(i + 2)] = first[std::clamp(i, 0, count - 1) * step];
    for (int i = 0; i < count; ++i) {
      const uint8_t* p = padded_.data() + i;
      first[i * step] = static_cast<uint8_t>((p[0] + p[4] + 4 * (p[1] + p[3]) + 6 * p[2] + 8) / 16);
    }
  };
  for (int y = 0; y < small.height; ++y) along(small.grey.data() + y * small.width, small.width, 1);
  for (int x = 0; x < small.width; ++x) along(small.grey.data() + x, small.height, small.width);
}

}  // namespace covis
