// SPDX-License-Identifier: Apache-2.0
// k-medians of descriptors under the Hamming distance, which is the squared Euclidean distance of bits: seeding of
// Arthur and Vassilvitskii, "k-means++: The Advantages of Careful Seeding", SODA 2007, section 2.2; the median of a
// cluster is its bitwise majority. All sums are exact integers, so the result does not depend on how the work is
// divided.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/core/random.h"
#include "covis/features/features.h"

namespace covis {

// Runs work on ranges [begin, end) that together cover [0, n), in any order and possibly in parallel.
using ForRanges = std::function<void(size_t n, const std::function<void(size_t begin, size_t end)>& work)>;

struct Clusters {
  AlignedVector<Descriptor> centres;  // at most k distinct centres; each has members
  std::vector<uint8_t> of;            // cluster of each member: the nearest centre, the first on a tie
};

// The members are descriptors[members[i]]; k from 2 to 256. Ends when no member changes its cluster or after
// `iterations` rounds. A bit that is set in half of a cluster's members keeps its value.
Clusters k_medians(std::span<const Descriptor> descriptors, std::span<const uint32_t> members, int k, int iterations,
                   Random& random, const ForRanges& for_ranges);

}  // namespace covis
