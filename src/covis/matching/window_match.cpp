// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/window_match.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "covis/core/reserve.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

// The best and second-best candidate inside one query's window.
struct BestTwo {
  int best = kHammingBeyond, second = kHammingBeyond;  // Hamming distances
  int best_level = -1, second_level = -1;
  int index = -1;

  void add(int distance, int level, int i) {
    if (distance < best || (distance == best && i < index)) {
      second = best;
      second_level = best_level;
      best = distance;
      best_level = level;
      index = i;
    } else if (distance < second) {
      second = distance;
      second_level = level;
    }
  }
};

// False when the feature's depth is another than the one expected by more than the window allows: the camera may be as
// far from where it is thought to be as the window says.
bool depth_in_window(const Features& features, size_t i, const WindowQuery& query, const Pinhole& camera) {
  if (!(query.disparity > 0) || !(features.depth[i] > 0)) return true;
  const float off = pixels_of_depth(camera, features.depth[i]) - query.disparity;
  if (!camera.depth_noise.known()) return std::abs(features.x[i] - query.u - off) <= query.radius;
  constexpr float kSigmas = 1.5f;                       // sigmas of the depth sensor, as its weight has them
  constexpr float kLeastShare = 0.1f, kPixelShare = 2;  // shares of the depth, and of the window as an angle
  const float share = kLeastShare + kPixelShare * query.radius / static_cast<float>(camera.fx);
  const float least = share * query.disparity;
  return std::abs(off) <= least ||
         std::abs(off) <= least + kSigmas / std::sqrt(disparity_of(features, i, camera).inv_sigma2);
}

bool error_within_bound(const Features& features, size_t i, const WindowQuery& query, const Pinhole& camera) {
  const Disparity disparity = query.disparity > 0 ? disparity_of(features, i, camera) : Disparity{};
  const Eigen::Vector3d residual = residual_of(features.x[i] - query.u, features.y[i] - query.v,
                                               disparity.pixels - query.disparity, camera, disparity);
  return within_bound(Chi2(residual, features.pyramid->inv_sigma2[features.level[i]], disparity), camera, disparity);
}

}  // namespace

void WindowMatcher::InGridOrder::gather(const Features& features) {
  const size_t n = features.grid.indices.size();
  for (auto* const values : {&x, &y}) {
    reserve_ahead(*values, n);
    values->resize(n);
  }
  reserve_ahead(level, n);
  level.resize(n);
  for (size_t k = 0; k < n; ++k) {
    const size_t i = features.grid.indices[k];
    x[k] = features.x[i];
    y[k] = features.y[i];
    level[k] = features.level[i];
  }
}

// Writes every feature of the cells under the window to the end of the list, and lengthens the list only for those
// inside, so that there is no branch to mispredict: most are outside. No more are written than there are.
std::span<const uint16_t> WindowMatcher::in_window(const Features& features, const WindowQuery& query) {
  assert(query.max_level >= query.min_level);
  size_t count = 0;
  const auto low = static_cast<unsigned>(query.min_level);
  const auto levels = static_cast<unsigned>(query.max_level) - low;
  features.grid.for_each_run(query.u, query.v, query.radius, [&](uint32_t first, uint32_t last) {
    for (uint32_t k = first; k < last; ++k) {
      inside_[count] = features.grid.indices[k];
      count += static_cast<size_t>((std::abs(ordered_.x[k] - query.u) <= query.radius) &
                                   (std::abs(ordered_.y[k] - query.v) <= query.radius) &
                                   (ordered_.level[k] - low <= levels));
    }
  });
  return {inside_.data(), count};
}

int WindowMatcher::match(const Features& features, std::span<const WindowQuery> queries, std::span<const uint8_t> taken,
                         const Pinhole& camera, const WindowMatchOptions& options, std::vector<int32_t>& match) {
  reserve_ahead(match, queries.size());
  match.assign(queries.size(), kUnlike);
  if (queries.empty()) return 0;
  reserve_ahead(owner_, static_cast<size_t>(features.size()));
  owner_.assign(static_cast<size_t>(features.size()), Owner{});
  ordered_.gather(features);
  reserve_ahead(inside_, ordered_.x.size());
  inside_.resize(ordered_.x.size());
  int count = 0;
  for (size_t q = 0; q < queries.size(); ++q) {
    const WindowQuery& query = queries[q];
    BestTwo best;
    for (const uint16_t i : in_window(features, query)) {
      if (!taken.empty() && taken[i]) continue;
      if (!depth_in_window(features, i, query, camera)) continue;
      if (options.within_bound && !error_within_bound(features, i, query, camera)) continue;
      best.add(hamming(*query.descriptor, features.descriptor[i]), features.level[i], i);
    }
    if (best.best > options.max_distance) continue;
    if (best.best_level == best.second_level &&
        static_cast<float>(best.best) > options.ratio * static_cast<float>(best.second)) {
      continue;
    }
    Owner& owner = owner_[static_cast<size_t>(best.index)];
    if (owner.query >= 0) {
      if (owner.distance <= best.best) {
        match[q] = kGivenAway;
        continue;
      }
      match[static_cast<size_t>(owner.query)] = kGivenAway;
      --count;
    }
    owner = {static_cast<int32_t>(q), best.best};
    match[q] = best.index;
    ++count;
  }
  return count;
}

int check_rotation(std::span<const float> angle_a, std::span<const float> angle_b, std::vector<uint8_t>& keep) {
  constexpr int kBins = 30;
  constexpr float kTwoPi = 2 * std::numbers::pi_v<float>;
  const auto bin_of = [&](size_t k) {
    float d = angle_a[k] - angle_b[k];
    d -= kTwoPi * std::floor(d / kTwoPi);
    return std::clamp(static_cast<int>(d * (kBins / kTwoPi)), 0, kBins - 1);
  };
  const size_t n = angle_a.size();
  std::array<int, kBins> counts{};
  for (size_t k = 0; k < n; ++k) {
    if (keep[k]) ++counts[static_cast<size_t>(bin_of(k))];
  }
  // The peak and its neighbours: a rotation near a bin's edge falls into two.
  std::array<int, kBins> smoothed{};
  for (int b = 0; b < kBins; ++b) {
    smoothed[static_cast<size_t>(b)] = counts[static_cast<size_t>((b + kBins - 1) % kBins)] +
                                       counts[static_cast<size_t>(b)] + counts[static_cast<size_t>((b + 1) % kBins)];
  }
  const int peak = static_cast<int>(std::max_element(smoothed.begin(), smoothed.end()) - smoothed.begin());
  int kept = 0;
  for (size_t k = 0; k < n; ++k) {
    if (!keep[k]) continue;
    const int away = std::abs(bin_of(k) - peak);
    if (std::min(away, kBins - away) <= 1) {
      ++kept;
    } else {
      keep[k] = 0;
    }
  }
  return kept;
}

}  // namespace covis
