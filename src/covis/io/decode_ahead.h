// SPDX-License-Identifier: Apache-2.0
// Decodes frames ahead of their use in a thread of its own, into memory that comes back for reuse.
#pragma once

#include <functional>
#include <thread>

#include "covis/core/blocking_queue.h"
#include "covis/io/sequence.h"

namespace covis::io {

class DecodeAhead {
 public:
  // The next frame into the given memory; nothing at the end.
  using Decode = std::function<Result<std::optional<Frame>>(Frame)>;

  DecodeAhead(Decode decode, int ahead)
      : ready_(static_cast<size_t>(std::max(1, ahead))),
        free_(static_cast<size_t>(std::max(1, ahead)) + 2),
        decode_(std::move(decode)) {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  Result<std::optional<Frame>> next(Frame recycled) {
    if (ended_) return std::optional<Frame>();
    if (!recycled.image.empty() && free_.size() < free_capacity()) free_.push(std::move(recycled));
    auto item = ready_.pop();
    if (!item) return std::optional<Frame>();
    ended_ = item->has_value() && !(*item)->has_value();
    return std::move(*item);
  }

 private:
  size_t free_capacity() const { return 2; }

  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      Frame memory;
      if (free_.size() > 0) {
        if (auto frame = free_.pop(stop)) memory = std::move(*frame);
      }
      Result<std::optional<Frame>> item = decode_(std::move(memory));
      const bool end = item.has_value() && !item->has_value();
      if (!ready_.push(std::move(item), stop) || end) return;
    }
  }

  BlockingQueue<Result<std::optional<Frame>>> ready_;
  BlockingQueue<Frame> free_;
  Decode decode_;
  bool ended_ = false;
  std::jthread thread_;
};

}  // namespace covis::io
