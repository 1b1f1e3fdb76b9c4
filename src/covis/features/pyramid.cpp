// SPDX-License-Identifier: Apache-2.0
#include "covis/features/pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "covis/core/simd_targets.h"

namespace covis {
namespace {

constexpr int kBits = kResizeBits;
constexpr int kOne = 1 << kBits;

std::vector<BilinearResizer::Tap> make_taps(int from, int to) {
  std::vector<BilinearResizer::Tap> taps(static_cast<size_t>(to));
  const double factor = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const double at = std::clamp((i + 0.5) * factor - 0.5, 0.0, static_cast<double>(from - 1));
    const int index = std::min(static_cast<int>(at), from - 1);
    taps[static_cast<size_t>(i)] = {index, std::min(index + 1, from - 1),
                                    static_cast<int>(std::lround((at - index) * kOne))};
  }
  return taps;
}

int reflect(int i, int n) {
  if (i < 0) i = -i;
  if (i >= n) i = 2 * n - 2 - i;
  return std::clamp(i, 0, n - 1);
}

void blur_along(const uint8_t* from, uint16_t* to, int width) {
  const auto border = [&](int x) {
    int sum = 0;
    for (int k = 0; k < 7; ++k) sum += kGauss[static_cast<size_t>(k)] * from[reflect(x + k - 3, width)];
    to[x] = static_cast<uint16_t>(sum);
  };
  const int inner = std::max(3, width - 3);
  for (int x = 0; x < std::min(3, width); ++x) border(x);
  for (int x = 3; x < inner; ++x) {
    to[x] = static_cast<uint16_t>(18 * (from[x - 3] + from[x + 3]) + 33 * (from[x - 2] + from[x + 2]) +
                                  49 * (from[x - 1] + from[x + 1]) + 56 * from[x]);
  }
  for (int x = inner; x < width; ++x) border(x);
}

}  // namespace

void BilinearResizer::make_groups() {
  groups_.assign((columns_.size() + 7) / 8, {});
  for (size_t g = 0; g < groups_.size(); ++g) {
    ResizeGroup& group = groups_[g];
    group.base = std::min(columns_[8 * g].index, from_width_ - 16);
    for (size_t k = 0; k < 8; ++k) {
      const Tap& tap = columns_[std::min(8 * g + k, columns_.size() - 1)];
      if (group.base < 0 || tap.next - group.base > 15) return groups_.clear();
      group.pick[2 * k] = static_cast<uint8_t>(tap.index - group.base);
      group.pick[2 * k + 1] = static_cast<uint8_t>(tap.next - group.base);
      group.weight[2 * k] = static_cast<int16_t>(kOne - tap.weight);
      group.weight[2 * k + 1] = static_cast<int16_t>(tap.weight);
    }
  }
}

void BilinearResizer::mix_columns(const uint8_t* in, uint32_t* out) const {
  if (simd_enabled() && !groups_.empty()) return resize_columns(in, groups_.data(), groups_.size(), out);
  for (size_t x = 0; x < columns_.size(); ++x) {
    const Tap& c = columns_[x];
    out[x] = static_cast<uint32_t>(in[c.index] * (kOne - c.weight) + in[c.next] * c.weight);
  }
}

void BilinearResizer::resize(ImageView<const uint8_t> from, ImageView<uint8_t> to) {
  if (from.width != from_width_ || from.height != from_height_ || to.width != to_width_ || to.height != to_height_) {
    columns_ = make_taps(from.width, to.width);
    rows_ = make_taps(from.height, to.height);
    from_width_ = from.width;
    from_height_ = from.height;
    to_width_ = to.width;
    to_height_ = to.height;
    make_groups();
    for (auto& line : lines_) line.resize((columns_.size() + 7) / 8 * 8);
  }
  held_ = {-1, -1};  // source rows that are resized along x already
  const auto line = [&](int y) {
    const auto slot = static_cast<size_t>(y & 1);
    if (held_[slot] != y) {
      held_[slot] = y;
      mix_columns(from.row(y), lines_[slot].data());
    }
    return lines_[slot].data();
  };
  for (int y = 0; y < to.height; ++y) {
    const Tap& r = rows_[static_cast<size_t>(y)];
    const uint32_t* above = line(r.index);
    const uint32_t* below = line(r.next);
    const auto w1 = static_cast<uint32_t>(r.weight), w0 = static_cast<uint32_t>(kOne) - w1;
    uint8_t* out = to.row(y);
    if (simd_enabled() && to.width >= kWidestRow) {
      resize_rows(above, below, w1, to.width, out);
      continue;
    }
    for (int x = 0; x < to.width; ++x) {
      out[x] = static_cast<uint8_t>((above[x] * w0 + below[x] * w1 + (1u << (2 * kBits - 1))) >> (2 * kBits));
    }
  }
}

void GaussianBlur::apply(ImageView<const uint8_t> from, ImageU8& to) {
  to.resize(from.width, from.height);
  if (!simd_enabled() || from.width < kWidestRow) return apply_scalar(from, to);
  line_.resize(static_cast<size_t>(from.width) + 48);
  for (int y = 0; y < from.height; ++y) {
    std::array<const uint8_t*, 7> rows;
    for (int k = 0; k < 7; ++k) rows[static_cast<size_t>(k)] = from.row(reflect(y + k - 3, from.height));
    blur_row(rows.data(), from.width, line_.data() + 8, to.row(y));
  }
}

void GaussianBlur::apply_scalar(ImageView<const uint8_t> from, ImageU8& to) {
  const auto stride = static_cast<size_t>(from.width);
  rows_.resize(7 * stride);
  const auto ring = [&](int y) { return rows_.data() + static_cast<size_t>((y % 7 + 7) % 7) * stride; };
  for (int y = -3; y < 3; ++y) blur_along(from.row(reflect(y, from.height)), ring(y), from.width);
  for (int y = 0; y < from.height; ++y) {
    blur_along(from.row(reflect(y + 3, from.height)), ring(y + 3), from.width);
    const uint16_t* r[7];
    for (int k = 0; k < 7; ++k) r[k] = ring(y + k - 3);
    uint8_t* out = to.row(y);
    for (int x = 0; x < from.width; ++x) {
      const uint32_t sum =
          18u * (r[0][x] + r[6][x]) + 33u * (r[1][x] + r[5][x]) + 49u * (r[2][x] + r[4][x]) + 56u * r[3][x];
      out[x] = static_cast<uint8_t>((sum + 32768u) >> 16);
    }
  }
}

}  // namespace covis
