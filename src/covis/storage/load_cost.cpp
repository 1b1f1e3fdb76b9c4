// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/load_cost.h"

#include <algorithm>

namespace covis::storage {
namespace {

// Greatest memory for each, in its section and in the lists it becomes, bytes.
constexpr uint64_t kKeyFrameBytes = 3072, kPointBytes = 448, kFeatureBytes = 176, kNeighbourBytes = 24;

// A 32-bit number times any of the above is far from the end of 64 bits; more cannot be in any file.
constexpr uint64_t kMaxNumber = uint64_t{1} << 40;

uint64_t bytes_of(uint64_t key_frames, uint64_t points, uint64_t features) {
  return kKeyFrameBytes * std::min(key_frames, kMaxNumber) + kPointBytes * std::min(points, kMaxNumber) +
         kFeatureBytes * std::min(features, kMaxNumber);
}

std::string too_much(uint64_t bytes, uint64_t file_size) {
  if (bytes <= kMemoryTimes * counted_size(file_size)) return {};
  return "it would take " + std::to_string(bytes >> 20) + " MB of memory, more than " + std::to_string(kMemoryTimes) +
         " times its size, which no map of Covis does";
}

}  // namespace

uint64_t counted_size(uint64_t file_size) { return std::max(file_size, kLeastSize); }

std::string problem_of_counts(uint64_t key_frames, uint64_t points, uint64_t features, uint64_t file_size) {
  return too_much(bytes_of(key_frames, points, features), file_size);
}

Meetings meetings_of(const MapState& state) {
  std::vector<uint32_t> seen(state.points.size());
  for (const KeyFrameState& k : state.key_frames) {
    for (const uint32_t p : k.points) {
      if (p != MapState::kNone) ++seen[p];
    }
  }
  Meetings all;
  const uint64_t others = state.key_frames.empty() ? 0 : state.key_frames.size() - 1;
  for (const KeyFrameState& k : state.key_frames) {
    uint64_t met = 0;
    for (const uint32_t p : k.points) {
      if (p != MapState::kNone) met += seen[p] - 1;
    }
    all.meetings += met;
    all.neighbours += std::min(met, others);
  }
  return all;
}

std::string problem_of_meetings(const Meetings& meetings, const MapState& state, uint64_t file_size) {
  if (meetings.meetings > kMeetingTimes * counted_size(file_size)) {
    return "its key frames have points in common " + std::to_string(meetings.meetings) +
           " times, more than any map of a file of its size";
  }
  uint64_t features = 0;
  for (const KeyFrameState& k : state.key_frames) features += k.points.size();
  return too_much(
      bytes_of(state.key_frames.size(), state.points.size(), features) + kNeighbourBytes * meetings.neighbours,
      file_size);
}

}  // namespace covis::storage
