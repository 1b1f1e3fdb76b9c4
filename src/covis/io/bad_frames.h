// SPDX-License-Identifier: Apache-2.0
// Frames of a recording that can't be used: passed over where they are few or where that was asked for, else an error.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "covis/io/recording.h"

namespace covis::io {

// Bad frames are few where they are at most so large a share of a recording: they are passed over without being asked.
inline constexpr double kFewBadFrames = 0.01;

// Indices of the most stamps that rise when the others are left out; of equal ones the first.
std::vector<size_t> longest_rise(const std::vector<Timestamp>& stamps);

// Notes that `bad` of `all` are left out, "3 of 10 images have no depth image and are left out". More than a few, as a
// share of all, are a loss of the recording.
void note_left_out(size_t bad, size_t all, const std::string& what, Recording& recording, double few = kFewBadFrames);
// Notes that `bad` of `all` are left out, or fails where those are too many. first: what is wrong with the first.
Result<void> pass_over(size_t bad, size_t all, const std::string& what, const std::string& first, BadFrames bad_frames,
                       Recording& recording);
// Returns the indices of longest_rise() after it passed over the others. what: what the stamps are of, "frames"; name:
// of each, for messages.
Result<std::vector<size_t>> pass_over_fallen(const std::vector<Timestamp>& stamps, const std::string& what,
                                             const std::function<std::string(size_t)>& name, BadFrames bad_frames,
                                             Recording& recording);

// Leaves out frames of which a file is missing, or whose stamps do not rise or can't be used.
Result<void> leave_out_bad_frames(Recording& recording, BadFrames bad_frames);

}  // namespace covis::io
