// SPDX-License-Identifier: Apache-2.0
// Decodes frames ahead of their use in a thread of its own, into memory that comes back for reuse.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "covis/core/threads.h"
#include "covis/io/sequence.h"

namespace covis::io {

class DecodeAhead {
 public:
  using Item = Result<std::optional<Frame>>;
  // The next frame into the given memory; nothing at the end.
  using Decode = std::function<Item(Frame)>;
  // The rule for frames that come faster than they are taken: wait (recordings), or go on and drop those not taken
  // (live cameras: what is taken is never older than a frame).
  enum class WhenFull { wait, drop_old };

  // `ahead`: frames that may lie ready.
  DecodeAhead(Decode decode, int ahead, WhenFull when_full = WhenFull::wait)
      : ahead_(static_cast<size_t>(std::max(1, ahead))), when_full_(when_full), decode_(std::move(decode)) {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  // Waits for the next frame.
  Item next(Frame recycled) {
    std::unique_lock lock(mutex_);
    keep_memory(std::move(recycled));
    if (ended_) return std::optional<Frame>();
    changed_.wait(lock, [&] { return !ready_.empty(); });
    Item item = std::move(ready_.front());
    ready_.pop_front();
    ended_ = is_end(item);
    changed_.notify_all();
    return item;
  }

 private:
  static bool is_end(const Item& item) { return item && !*item; }

  void keep_memory(Frame frame) {
    // Never more than the frames that are ready, taken and being decoded.
    if (!frame.image.empty() && free_.size() < ahead_ + 2) free_.push_back(std::move(frame));
  }

  void run(const std::stop_token& stop) {
    if (when_full_ == WhenFull::wait) lower_thread_priority();  // a live camera's frame is wanted at once
    for (bool end = false; !end && !stop.stop_requested();) {
      Item item = decode_(free_memory());
      end = is_end(item);
      std::unique_lock lock(mutex_);
      if (when_full_ == WhenFull::drop_old && item && *item) drop_frames();
      if (!changed_.wait(lock, stop, [&] { return ready_.size() < ahead_; })) return;
      ready_.push_back(std::move(item));
      changed_.notify_all();
    }
  }

  Frame free_memory() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return {};
    Frame memory = std::move(free_.back());
    free_.pop_back();
    return memory;
  }

  // Frames only: an error or the end is always reported.
  void drop_frames() {
    for (Item& item : ready_) {
      if (item && *item) keep_memory(std::move(**item));
    }
    std::erase_if(ready_, [](const Item& item) { return item && *item; });
  }

  const size_t ahead_;
  const WhenFull when_full_;
  const Decode decode_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Item> ready_;   // guarded by mutex_
  std::vector<Frame> free_;  // guarded by mutex_
  bool ended_ = false;       // the taker's alone
  std::jthread thread_;      // last: it uses the rest
};

}  // namespace covis::io
