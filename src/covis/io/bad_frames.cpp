// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bad_frames.h"

#include <algorithm>

#include "covis/core/stamp_bounds.h"
#include "covis/io/files.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

// Returns what is wrong with the frame's files; empty: nothing.
std::string missing_file(const FrameFiles& frame) {
  const auto missing = [](const fs::path& file) { return !file.empty() && !is_there(file); };
  if (missing(frame.image)) return frame.image + ": the file is listed but missing";
  if (missing(frame.right)) return frame.right + ": the right image of " + frame.image + " is missing";
  if (missing(frame.depth)) return frame.depth + ": the depth image of " + frame.image + " is missing";
  return {};
}

// Keeps the frames that the indices name.
void keep(std::vector<FrameFiles>& frames, const std::vector<size_t>& indices) {
  std::vector<FrameFiles> kept;
  for (const size_t i : indices) kept.push_back(std::move(frames[i]));
  frames = std::move(kept);
}

Result<void> leave_out_missing(Recording& recording, BadFrames bad_frames) {
  if (recording.kind == SequenceKind::bag) return {};  // its images are no files
  std::vector<FrameFiles>& frames = recording.frames;
  std::vector<size_t> there;
  std::string first;
  for (size_t i = 0; i < frames.size(); ++i) {
    const std::string problem = missing_file(frames[i]);
    if (problem.empty()) there.push_back(i);
    if (first.empty()) first = problem;
  }
  if (there.size() == frames.size()) return {};
  const size_t all = frames.size(), bad = all - there.size();
  if (auto passed = pass_over(bad, all, "frames lack a file", first, bad_frames, recording.notes); !passed)
    return passed;
  keep(frames, there);
  return {};
}

Result<void> leave_out_unstamped(Recording& recording, BadFrames bad_frames) {
  std::vector<FrameFiles>& frames = recording.frames;
  std::vector<Timestamp> stamps;
  for (const FrameFiles& frame : frames) {
    if (!is_usable_stamp(frame.stamp))
      return fail(frame.image + ": its stamp " + stamp_text(frame.stamp) + " s is too far from the epoch");
    stamps.push_back(frame.stamp);
  }
  const std::vector<size_t> rising = longest_rise(stamps);
  if (rising.size() == frames.size()) return {};
  std::string first;
  for (size_t i = 1; i < frames.size() && first.empty(); ++i) {
    if (stamps[i] > stamps[i - 1]) continue;
    first = frames[i].image + ": its stamp " + stamp_text(stamps[i]) + " s is not later than " +
            stamp_text(stamps[i - 1]) + " s of the frame before it; stamps must rise";
  }
  const size_t all = frames.size(), bad = all - rising.size();
  if (auto passed = pass_over(bad, all, "frames have stamps that do not rise", first, bad_frames, recording.notes);
      !passed) {
    return passed;
  }
  keep(frames, rising);
  return {};
}

}  // namespace

std::vector<size_t> longest_rise(const std::vector<Timestamp>& stamps) {
  // ends[k]: the earliest end of a rise of k + 1 stamps so far.
  std::vector<size_t> ends, before(stamps.size());
  for (size_t i = 0; i < stamps.size(); ++i) {
    const auto at = std::lower_bound(ends.begin(), ends.end(), stamps[i],
                                     [&](size_t end, Timestamp stamp) { return stamps[end] < stamp; });
    if (at != ends.end() && stamps[*at] == stamps[i]) continue;
    if (at != ends.begin()) before[i] = *(at - 1);
    if (at == ends.end()) {
      ends.push_back(i);
    } else {
      *at = i;
    }
  }
  std::vector<size_t> rise(ends.size());
  for (size_t k = rise.size(); k > 0; --k) rise[k - 1] = k == rise.size() ? ends.back() : before[rise[k]];
  return rise;
}

Result<void> pass_over(size_t bad, size_t all, const std::string& what, const std::string& first, BadFrames bad_frames,
                       std::vector<std::string>& notes) {
  const std::string count = std::to_string(bad) + " of " + std::to_string(all) + " " + what;
  if (bad_frames == BadFrames::passed_over_where_few &&
      static_cast<double>(bad) > kFewBadFrames * static_cast<double>(all)) {
    return fail(first + " (" + count + "; --skip-bad leaves them out)");
  }
  notes.push_back(count + " and are left out; the first: " + first);
  return {};
}

Result<void> leave_out_bad_frames(Recording& recording, BadFrames bad_frames) {
  if (auto left = leave_out_missing(recording, bad_frames); !left) return left;
  return leave_out_unstamped(recording, bad_frames);
}

}  // namespace covis::io
