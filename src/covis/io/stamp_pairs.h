// SPDX-License-Identifier: Apache-2.0
// Pairing of images with the depth images, or right images, that belong to them.
#pragma once

#include <utility>
#include <vector>

#include "covis/core/time.h"

namespace covis::io {

inline constexpr Timestamp kLargestPairDifference = 20'000'000;  // ns

// Pairs by stamps at most kLargestPairDifference apart, nearest first, each used at most once. Returns indices into
// both lists, in the order of the images. Takes n log n steps, however many stamps lie close together.
std::vector<std::pair<size_t, size_t>> pair_by_stamps(const std::vector<Timestamp>& images,
                                                      const std::vector<Timestamp>& others);

}  // namespace covis::io
