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
  if (auto passed = pass_over(bad, all, "frames lack a file", first, bad_frames, recording); !passed) return passed;
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
  const auto name = [&](size_t i) { return frames[i].image; };
  const auto rising = pass_over_fallen(stamps, "frames", name, bad_frames, recording);
  if (!rising) return tl::unexpected(rising.error());
  if (rising->size() < frames.size()) keep(frames, *rising);
  return {};
}

bool are_few(size_t bad, size_t all, double few = kFewBadFrames) {
  return static_cast<double>(bad) <= few * static_cast<double>(all);
}

std::string count_text(size_t bad, size_t all, const std::string& what) {
  return std::to_string(bad) + " of " + std::to_string(all) + " " + what;
}

void note_loss(size_t bad, size_t all, const std::string& text, Recording& recording, double few = kFewBadFrames) {
  recording.notes.push_back(text);
  if (!are_few(bad, all, few)) recording.losses.push_back(text);
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

void note_left_out(size_t bad, size_t all, const std::string& what, Recording& recording, double few) {
  note_loss(bad, all, count_text(bad, all, what) + " and are left out", recording, few);
}

Result<void> pass_over(size_t bad, size_t all, const std::string& what, const std::string& first, BadFrames bad_frames,
                       Recording& recording) {
  const std::string count = count_text(bad, all, what);
  if (bad_frames == BadFrames::passed_over_where_few && !are_few(bad, all))
    return fail(first + " (" + count + "; --skip-bad leaves them out)");
  note_loss(bad, all, count + " and are left out; the first: " + first, recording);
  return {};
}

Result<std::vector<size_t>> pass_over_fallen(const std::vector<Timestamp>& stamps, const std::string& what,
                                             const std::function<std::string(size_t)>& name, BadFrames bad_frames,
                                             Recording& recording) {
  std::vector<size_t> rising = longest_rise(stamps);
  const size_t all = stamps.size(), bad = all - rising.size();
  if (bad == 0) return rising;
  size_t fallen = 1;
  while (stamps[fallen] > stamps[fallen - 1]) ++fallen;
  const std::string first = name(fallen) + ": its stamp " + stamp_text(stamps[fallen]) + " s is not later than " +
                            stamp_text(stamps[fallen - 1]) + " s of the one before it; stamps must rise";
  if (auto passed = pass_over(bad, all, what + " have stamps that do not rise", first, bad_frames, recording); !passed)
    return tl::unexpected(passed.error());
  return rising;
}

Result<void> leave_out_bad_frames(Recording& recording, BadFrames bad_frames) {
  if (auto left = leave_out_missing(recording, bad_frames); !left) return left;
  return leave_out_unstamped(recording, bad_frames);
}

}  // namespace covis::io
