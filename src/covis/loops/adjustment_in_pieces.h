// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of a large submap, piece by piece: the key frames of a piece move together, what sees the same
// holds them, and the next piece starts from there. The time grows with the number of key frames, where that of one
// problem grows with its third power as soon as many see points in common. What is wrong over longer distances than a
// piece stays, so that it is for submaps that a pose graph has brought into shape. Source: block coordinate descent;
// the pieces are those of a local adjustment (mapping/local_adjustment.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "covis/loops/join_report.h"
#include "covis/map/shared_map.h"

namespace covis {

// The key frames of a submap, each in one piece of at most `size`. A piece begins with the first key frame that is in
// none (the last one, if `backwards`) and grows by those that share most points with it.
std::vector<std::vector<KeyFrameId>> pieces_of(const Map& map, uint32_t submap, size_t size, bool backwards);

// Adjusts them one after the other; the submap's root stays. Observations found to be outliers go. The cost is the sum
// over the pieces, in which what two pieces see counts twice. Nothing when no piece could be adjusted.
std::optional<AdjustedCost> adjust_in_pieces(SharedMap& map, const std::vector<std::vector<KeyFrameId>>& pieces,
                                             int iterations);

}  // namespace covis
