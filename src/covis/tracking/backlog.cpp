// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/backlog.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace covis {
namespace {

constexpr size_t kMost = 180;  // frames of a list: six seconds of most cameras; some 0.25 MB each with 4000 features

void append(UnlocatedFrame frame, std::vector<UnlocatedFrame>& frames) {
  if (frames.size() == kMost) frames.erase(frames.begin());
  frames.push_back(std::move(frame));
}

UnlocatedFrame unlocated(const TrackedFrame& frame) { return {frame.index, frame.stamp, frame.features, {}}; }

}  // namespace

Backlog::Backlog() {
  for (auto* frames : {&settled_, &frames_, &for_now_}) frames->reserve(kMost);
}

void Backlog::keep(const TrackedFrame& frame) { append(unlocated(frame), frames_); }

void Backlog::keep_for_now(const TrackedFrame& frame) { append(unlocated(frame), for_now_); }

void Backlog::found_at(KeyFrameId key_frame) {
  for (auto frame = frames_.rbegin(); frame != frames_.rend() && !frame->near.valid(); ++frame) frame->near = key_frame;
}

void Backlog::settle() {
  for_now_.clear();
  for (UnlocatedFrame& frame : frames_) append(std::move(frame), settled_);
  frames_.clear();
}

void Backlog::lost() {
  for (UnlocatedFrame& frame : for_now_) append(std::move(frame), frames_);
  for_now_.clear();
  for (UnlocatedFrame& frame : frames_) frame.near = {};
}

std::vector<UnlocatedFrame> Backlog::take() {
  std::vector<UnlocatedFrame> taken(std::make_move_iterator(settled_.rbegin()),
                                    std::make_move_iterator(settled_.rend()));
  settled_.clear();
  return taken;
}

std::vector<UnlocatedFrame> Backlog::take_with_found() {
  std::vector<UnlocatedFrame> found;
  std::copy_if(frames_.rbegin(), frames_.rend(), std::back_inserter(found),
               [](const UnlocatedFrame& frame) { return frame.near.valid(); });
  found.insert(found.end(), std::make_move_iterator(settled_.rbegin()), std::make_move_iterator(settled_.rend()));
  settled_.clear();
  return found;
}

}  // namespace covis
