// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/backlog.h"

#include <algorithm>
#include <utility>

namespace covis {
namespace {

constexpr size_t kMost = 60;  // frames: two seconds of most cameras, some 8 MB with 2000 features each

void append(UnlocatedFrame frame, std::vector<UnlocatedFrame>& frames) {
  if (frames.size() == kMost) frames.erase(frames.begin());
  frames.push_back(std::move(frame));
}

UnlocatedFrame unlocated(const TrackedFrame& frame) { return {frame.index, frame.stamp, frame.features, {}}; }

}  // namespace

Backlog::Backlog() {
  frames_.reserve(kMost);
  for_now_.reserve(kMost);
}

void Backlog::keep(const TrackedFrame& frame) { append(unlocated(frame), frames_); }

void Backlog::keep_for_now(const TrackedFrame& frame) { append(unlocated(frame), for_now_); }

void Backlog::lost() {
  for (UnlocatedFrame& frame : for_now_) append(std::move(frame), frames_);
  for_now_.clear();
  for (UnlocatedFrame& frame : frames_) frame.near = {};
}

void Backlog::found_at(KeyFrameId key_frame) {
  for (auto frame = frames_.rbegin(); frame != frames_.rend() && !frame->near.valid(); ++frame) frame->near = key_frame;
}

std::vector<UnlocatedFrame> Backlog::take() {
  const auto waiting = std::find_if(frames_.begin(), frames_.end(), [](const auto& f) { return !f.near.valid(); });
  std::vector<UnlocatedFrame> taken(std::make_move_iterator(frames_.begin()), std::make_move_iterator(waiting));
  frames_.erase(frames_.begin(), waiting);
  std::reverse(taken.begin(), taken.end());
  return taken;
}

}  // namespace covis
