// SPDX-License-Identifier: Apache-2.0
// Decodes frames ahead of their use in a thread of its own, into recycled memory.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "covis/core/failure_reason.h"
#include "covis/core/threads.h"
#include "covis/io/sequence.h"

namespace covis::io {

class DecodeAhead {
 public:
  using Item = Result<std::optional<Frame>>;
  // Decodes the next frame into the given memory; returns nullopt at the end.
  using Decode = std::function<Item(Frame)>;

  // ahead: greatest number of frames in the queue; the frame being decoded counts as one of them.
  DecodeAhead(Decode decode, int ahead) : ahead_(static_cast<size_t>(std::max(1, ahead))), decode_(std::move(decode)) {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  // Waits for the next frame. Several threads may ask; each is given the end.
  Item next(Frame recycled) {
    std::unique_lock lock(mutex_);
    if (ended_) return std::optional<Frame>();
    keep_memory(std::move(recycled));
    changed_.wait(lock, [&] { return ended_ || !ready_.empty(); });
    if (ended_) return std::optional<Frame>();
    Item item = std::move(ready_.front());
    ready_.pop_front();
    ended_ = is_end(item);
    if (ended_) free_.clear();
    changed_.notify_all();
    return item;
  }

 private:
  static bool is_end(const Item& item) { return item && !*item; }

  void keep_memory(Frame frame) {
    // Keeps no more than the frames that are ready or being decoded, and the one taken.
    if (!frame.image.empty() && free_.size() < ahead_ + 1) free_.push_back(std::move(frame));
  }

  void run(const std::stop_token& stop) {
    lower_thread_priority();
    for (bool end = false; !end && !stop.stop_requested();) {
      // Before decoding: a frame that waits for its place takes memory as those that have one.
      if (!wait_for_room(stop)) return;
      Item item = decode_next();
      end = is_end(item);
      const std::lock_guard lock(mutex_);
      ready_.push_back(std::move(item));
      changed_.notify_all();
    }
  }

  // After an exception there is only the end: what threw it may throw it forever.
  Item decode_next() {
    if (failed_) return std::optional<Frame>();
    try {
      return decode_(free_memory());
    } catch (const std::exception& error) {
      failed_ = true;
      return fail("no more frames can be read: " + std::string(reason_of(error)));
    }
  }

  // False: it is to stop.
  bool wait_for_room(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    return changed_.wait(lock, stop, [&] { return ready_.size() < ahead_; });
  }

  Frame free_memory() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return {};
    Frame memory = std::move(free_.back());
    free_.pop_back();
    return memory;
  }

  const size_t ahead_;
  const Decode decode_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Item> ready_;   // guarded by mutex_
  std::vector<Frame> free_;  // guarded by mutex_
  bool failed_ = false;      // used by the decoding thread only
  bool ended_ = false;       // used by the consumer thread only
  std::jthread thread_;      // last member: it uses the others
};

}  // namespace covis::io
