// SPDX-License-Identifier: Apache-2.0
// Frames of a recording that can't be used: passed over where they are few or where that was asked for, else an error.
#pragma once

#include <string>
#include <vector>

#include "covis/io/recording.h"

namespace covis::io {

// Bad frames are passed over without being asked where they are at most so large a share of a recording.
inline constexpr double kFewBadFrames = 0.01;

// Indices of the most stamps that rise when the others are left out; of equal ones the first.
std::vector<size_t> longest_rise(const std::vector<Timestamp>& stamps);

// Adds a note that `bad` of `all` are left out, or fails where those are too many. first: what is wrong with the first.
Result<void> pass_over(size_t bad, size_t all, const std::string& what, const std::string& first, BadFrames bad_frames,
                       std::vector<std::string>& notes);

// Leaves out frames of which a file is missing, or whose stamps do not rise or can't be used.
Result<void> leave_out_bad_frames(Recording& recording, BadFrames bad_frames);

}  // namespace covis::io
