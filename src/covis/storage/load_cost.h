// SPDX-License-Identifier: Apache-2.0
// Bounds on what loading a map may cost, by the size of its file: a small file cannot take much memory or time
// (docs/map-format.md, "Reading and writing safely"). What is beyond is refused before it is paid for.
#pragma once

#include <cstdint>
#include <string>

#include "covis/map/map_state.h"

namespace covis::storage {

inline constexpr uint64_t kMemoryTimes = 40;    // greatest memory, in sizes of the file
inline constexpr uint64_t kUnpackedTimes = 16;  // greatest sum of the uncompressed sections, in sizes of the file
inline constexpr uint64_t kMeetingTimes = 16;   // greatest number of meetings, in bytes of the file
inline constexpr uint64_t kLeastSize = 65536;   // bytes as which a smaller file counts

// The size of the file as it is counted, bytes.
uint64_t counted_size(uint64_t file_size);

// Returns what is wrong with these numbers in a file of this size; empty: nothing.
std::string problem_of_counts(uint64_t key_frames, uint64_t points, uint64_t features, uint64_t file_size);

// A meeting is an observation of a point together with another observation of it; two key frames are neighbours when
// they meet at a point. Loading walks all meetings, and a map keeps all neighbours.
struct Meetings {
  uint64_t meetings = 0;    // each counted once for each of the two
  uint64_t neighbours = 0;  // greatest number of entries that lists of neighbours can have
};
// Takes time for each observation, not for each meeting. Indices of points must be in range.
Meetings meetings_of(const MapState& state);

// Returns what is wrong with them in a file of this size; empty: nothing.
std::string problem_of_meetings(const Meetings& meetings, const MapState& state, uint64_t file_size);

}  // namespace covis::storage
