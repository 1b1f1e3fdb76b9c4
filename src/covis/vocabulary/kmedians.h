// SPDX-License-Identifier: Apache-2.0
// k-medians of descriptors under the Hamming distance, which is the squared Euclidean distance of bits: seeding of
// Arthur and Vassilvitskii, "k-means++: The Advantages of Careful Seeding", SODA 2007, section 2.2; the median of a
// cluster is its bitwise majority. All sums are of whole numbers, so that the result is the same however the work is
// shared out.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/core/random.h"
#include "covis/features/features.h"

namespace covis {

// Does work on [begin, end) ranges that together are [0, n), in any order, some of them at the same time.
using ForRanges = std::function<void(size_t n, const std::function<void(size_t begin, size_t end)>& work)>;

struct Clusters {
  AlignedVector<Descriptor> centres;  // distinct; at most k; none has lost all its members
  std::vector<uint8_t> of;            // the cluster of each member: the nearest centre, the first on a tie
};

// The members are descriptors[members[i]]; k from 2 to 256. Ends when no member changes its cluster or after
// `iterations` rounds. A bit that half of a cluster's members have set stays as it was.
Clusters k_medians(std::span<const Descriptor> descriptors, std::span<const uint32_t> members, int k, int iterations,
                   Random& random, const ForRanges& for_ranges);

}  // namespace covis
