// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/backlog.h"

#include <algorithm>

namespace covis {
namespace {

constexpr size_t kMost = 60;  // frames: two seconds of most cameras, some 8 MB with 2000 features each

}  // namespace

Backlog::Backlog() { frames_.reserve(kMost); }

void Backlog::keep(const TrackedFrame& frame) {
  if (frames_.size() == kMost) frames_.erase(frames_.begin());
  frames_.push_back({frame.index, frame.stamp, frame.features, {}});
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
