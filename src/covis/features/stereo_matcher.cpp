// SPDX-License-Identifier: Apache-2.0
#include "covis/features/stereo_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "covis/core/reserve.h"
#include "covis/core/simd_targets.h"
#include "covis/features/simd.h"
#include "covis/geometry/measurement.h"

namespace covis {
namespace {

constexpr int kHalfPatch = 5;  // half width of the 11x11 patches compared
constexpr int kSlide = 5;      // search range to either side, pixels
constexpr int kMaxHamming = 75;
constexpr int kFineLevels = 3;

using Sads = std::array<int, 2 * kSlide + 1>;

// Compares the patch with top left `a` with those at b, b + 1, ...
void slide(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b, Sads& sad) {
  if (simd_enabled()) return slide_sad(a, stride_a, b, stride_b, sad.data());
  const auto sum_over_patch = [](auto&& value) {
    int sum = 0;
    for (int y = 0; y <= 2 * kHalfPatch; ++y) {
      for (int x = 0; x <= 2 * kHalfPatch; ++x) sum += value(x, y);
    }
    return sum;
  };
  const int sum_a = sum_over_patch([&](int x, int y) { return a[y * stride_a + x]; });
  for (int s = 0; s <= 2 * kSlide; ++s) {
    const int sum_b = sum_over_patch([&](int x, int y) { return b[y * stride_b + x + s]; });
    const int mean = quarters_of_mean(sum_b - sum_a);
    sad[static_cast<size_t>(s)] = sum_over_patch(
        [&](int x, int y) { return std::abs(4 * (a[y * stride_a + x] - b[y * stride_b + x + s]) + mean); });
  }
}

struct PatchMatch {
  float disparity = 0;  // pixels
  int sad = 0;
};

// Compares the patch around a left keypoint with those around a right one, on the left keypoint's level; to a part of a
// pixel. Nothing: none is clearly the best.
std::optional<PatchMatch> compare_patches(const OrbExtractor& left, const OrbExtractor& right, int level,
                                          const Eigen::Vector2f& left_at, const Eigen::Vector2f& right_at) {
  const auto a = left.level(level), b = right.level(level);
  const Eigen::Vector2f in_a = left.to_level(level, left_at.x(), left_at.y());
  const int xl = static_cast<int>(std::lround(in_a.x())), y = static_cast<int>(std::lround(in_a.y()));
  const int xr = static_cast<int>(std::lround(right.to_level(level, right_at.x(), right_at.y()).x()));
  if (xr - kSlide - kHalfPatch < 0 || xr + kSlide + kHalfPatch >= b.width) return std::nullopt;
  Sads sad;
  // 16 and 24 bytes are read for rows of 11 and 21, which is safe because keypoints stay clear of the last rows.
  slide(a.row(y - kHalfPatch) + xl - kHalfPatch, a.stride, b.row(y - kHalfPatch) + xr - kSlide - kHalfPatch, b.stride,
        sad);
  const int at = static_cast<int>(std::min_element(sad.begin(), sad.end()) - sad.begin()) - kSlide;
  if (at == -kSlide || at == kSlide) return std::nullopt;
  const auto m = static_cast<size_t>(at + kSlide);
  const float s0 = static_cast<float>(sad[m - 1]), s1 = static_cast<float>(sad[m]), s2 = static_cast<float>(sad[m + 1]);
  const float curvature = s0 + s2 - 2 * s1;
  if (!(curvature > 0)) return std::nullopt;
  const float offset = (s0 - s2) / (2 * curvature);
  if (std::abs(offset) > 1) return std::nullopt;
  // The disparity is that between the patches, at integer pixels: the keypoints' own fractions do not enter.
  return PatchMatch{(static_cast<float>(xl - xr - at) - offset) * left.stretch(level), sad[m]};
}

}  // namespace

void StereoMatcher::match(const OrbExtractor& left, const OrbExtractor& right, const Pinhole& camera,
                          AlignedVector<float>& u_right, AlignedVector<float>& depth) {
  const KeyPoints& l = left.keypoints();
  const KeyPoints& r = right.keypoints();
  const ScalePyramid& pyramid = *left.pyramid();
  u_right.assign(l.size(), -1.0f);
  depth.assign(l.size(), 0.0f);
  const int height = left.level(0).height;

  // Right keypoints by the rows in which they may match: 2 pixels at their scale up and down.
  const auto rows_of = [&](size_t j) {
    const float reach = 2 * pyramid.scale[r.level[j]];
    return std::pair{std::max(0, static_cast<int>(std::floor(r.y[j] - reach))),
                     std::min(height - 1, static_cast<int>(std::ceil(r.y[j] + reach)))};
  };
  row_offsets_.assign(static_cast<size_t>(height) + 1, 0);
  for (size_t j = 0; j < r.size(); ++j) {
    const auto [first, last] = rows_of(j);
    for (int y = first; y <= last; ++y) ++row_offsets_[static_cast<size_t>(y) + 1];
  }
  for (size_t y = 1; y < row_offsets_.size(); ++y) row_offsets_[y] += row_offsets_[y - 1];
  reserve_ahead(row_items_, row_offsets_.back());
  row_items_.resize(row_offsets_.back());
  next_.assign(row_offsets_.begin(), row_offsets_.end() - 1);
  for (size_t j = 0; j < r.size(); ++j) {
    const auto [first, last] = rows_of(j);
    for (int y = first; y <= last; ++y) row_items_[next_[static_cast<size_t>(y)]++] = static_cast<uint32_t>(j);
  }

  accepted_.clear();
  row_distances_.clear();
  row_differences_.clear();
  reserve_ahead(row_differences_, l.size());
  row_error_ = 0;
  const auto max_disparity = static_cast<float>(camera.fx);  // disparity of a point at a depth of one baseline
  // Columns that are off can make what is far away lie behind infinity, before they are taken out.
  const bool is_off = camera.right_columns.any();
  const float min_disparity = is_off ? -static_cast<float>(kMostRectificationError) : 0;
  for (size_t i = 0; i < l.size(); ++i) {
    const auto row = static_cast<size_t>(std::clamp(static_cast<int>(std::lround(l.y[i])), 0, height - 1));
    int best = kMaxHamming;
    size_t best_j = r.size();
    for (uint32_t k = row_offsets_[row]; k < row_offsets_[row + 1]; ++k) {
      const size_t j = row_items_[k];
      if (std::abs(r.level[j] - l.level[i]) > 1) continue;
      const float disparity = l.x[i] - r.x[j];
      if (disparity < min_disparity || disparity > max_disparity) continue;
      const int d = hamming(l.descriptor[i], r.descriptor[j]);
      if (d < best) {
        best = d;
        best_j = j;
      }
    }
    if (best_j == r.size()) continue;

    const auto patches = compare_patches(left, right, l.level[i], {l.x[i], l.y[i]}, {r.x[best_j], r.y[best_j]});
    if (!patches) continue;
    float disparity = patches->disparity;
    if (is_off) {
      const double u = camera.rectified_column(static_cast<double>(l.x[i] - disparity), static_cast<double>(l.y[i]));
      disparity = l.x[i] - static_cast<float>(u);
    }
    if (disparity < 0 || disparity > max_disparity) continue;
    disparity = std::max(disparity, kLeastDisparity);
    u_right[i] = l.x[i] - disparity;
    depth[i] = static_cast<float>(camera.bf) / disparity;
    accepted_.emplace_back(patches->sad, static_cast<uint32_t>(i));
    const float lower = r.y[best_j] - l.y[i];
    row_distances_.push_back(std::abs(lower) / pyramid.scale[r.level[best_j]]);
    if (l.level[i] == r.level[best_j] && l.level[i] < kFineLevels)
      row_differences_.push_back({r.x[best_j], l.y[i], lower});
  }
  if (accepted_.empty()) return;
  const auto usual = row_distances_.begin() + static_cast<ptrdiff_t>(row_distances_.size() / 2);
  std::nth_element(row_distances_.begin(), usual, row_distances_.end());
  row_error_ = static_cast<double>(*usual);
  const auto middle = accepted_.begin() + static_cast<ptrdiff_t>(accepted_.size() / 2);
  std::nth_element(accepted_.begin(), middle, accepted_.end());
  const double bound = 1.5 * 1.4 * middle->first;
  for (const auto& [sad, i] : accepted_) {
    if (sad <= bound) continue;
    u_right[i] = -1;
    depth[i] = 0;
  }
}

}  // namespace covis
