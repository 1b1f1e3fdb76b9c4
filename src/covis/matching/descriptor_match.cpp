// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/descriptor_match.h"

#include "covis/matching/nearest_row.h"
#include "covis/matching/window_match.h"

namespace covis {

std::vector<FeatureMatch> match_descriptors(const Features& a, std::span<const uint8_t> use_a, const Features& b,
                                            std::span<const uint8_t> use_b, const DescriptorMatchOptions& options) {
  const DescriptorPlanes to(b, use_b);
  AlignedVector<uint64_t> column(to.padded_size(), kFarthest);  // for each feature of b the nearest of a
  std::vector<FeatureMatch> candidates;                         // b: position in `to` for now
  for (int32_t i = 0; i < a.size(); ++i) {
    const auto at = static_cast<size_t>(i);
    if (!use_a.empty() && !use_a[at]) continue;
    const NearestTwo nearest = nearest_row(a.descriptor[at], static_cast<uint32_t>(i), to, column.data());
    const int best = near_distance(nearest.best), second = near_distance(nearest.second);
    if (best <= options.max_distance && static_cast<float>(best) < options.ratio * static_cast<float>(second))
      candidates.push_back({i, static_cast<int32_t>(near_index(nearest.best))});
  }
  std::erase_if(candidates, [&](const FeatureMatch& m) {
    return near_index(column[static_cast<size_t>(m.b)]) != static_cast<uint32_t>(m.a);
  });
  for (FeatureMatch& m : candidates) m.b = to.feature(static_cast<size_t>(m.b));
  keep_consistent_rotations(a, b, candidates);
  return candidates;
}

void keep_consistent_rotations(const Features& a, const Features& b, std::vector<FeatureMatch>& matches) {
  std::vector<float> angle_a(matches.size()), angle_b(matches.size());
  for (size_t k = 0; k < matches.size(); ++k) {
    angle_a[k] = a.angle[static_cast<size_t>(matches[k].a)];
    angle_b[k] = b.angle[static_cast<size_t>(matches[k].b)];
  }
  std::vector<uint8_t> keep(matches.size(), 1);
  check_rotation(angle_a, angle_b, keep);
  size_t kept = 0;
  for (size_t k = 0; k < matches.size(); ++k) {
    if (keep[k]) matches[kept++] = matches[k];
  }
  matches.resize(kept);
}

}  // namespace covis
