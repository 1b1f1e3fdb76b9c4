// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/descriptor_match.h"

#include "covis/features/hamming.h"
#include "covis/matching/descriptor_subset.h"
#include "covis/matching/window_match.h"

namespace covis {

std::vector<FeatureMatch> match_descriptors(const Features& a, std::span<const uint8_t> use_a, const Features& b,
                                            std::span<const uint8_t> use_b, const DescriptorMatchOptions& options) {
  const DescriptorSubset to(b, use_b);
  const size_t n = to.size();
  std::vector<uint16_t> row(n);
  std::vector<uint16_t> column_best(n, 257);  // for each feature of b the least distance to any of a, …
  std::vector<int32_t> column_owner(n, -1);   // … and whose it is (the first on a tie)
  std::vector<FeatureMatch> candidates;       // b: position in `to` for now
  for (int32_t i = 0; i < a.size(); ++i) {
    if (!use_a.empty() && !use_a[static_cast<size_t>(i)]) continue;
    hamming_row(a.descriptor[static_cast<size_t>(i)], to.descriptors(), static_cast<int>(n), row.data());
    int best = 257, second = 257;
    size_t best_j = 0;
    for (size_t j = 0; j < n; ++j) {
      const int d = row[j];
      if (d < column_best[j]) {
        column_best[j] = static_cast<uint16_t>(d);
        column_owner[j] = i;
      }
      if (d < best) {
        second = best;
        best = d;
        best_j = j;
      } else if (d < second) {
        second = d;
      }
    }
    if (best <= options.max_distance && static_cast<float>(best) < options.ratio * static_cast<float>(second)) {
      candidates.push_back({i, static_cast<int32_t>(best_j)});
    }
  }
  std::erase_if(candidates, [&](const FeatureMatch& m) { return column_owner[static_cast<size_t>(m.b)] != m.a; });
  for (FeatureMatch& m : candidates) m.b = to.feature(static_cast<size_t>(m.b));
  if (options.check_rotation) keep_consistent_rotations(a, b, candidates);
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
