// SPDX-License-Identifier: Apache-2.0
// Hands frames of a live camera from the thread that captures them to the one that takes them: the newest one only, so
// that no frame that is taken is older than the camera's last one, and nothing queues up. What happened to the camera
// is handed on as well, in its order, and is never dropped.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "covis/core/error.h"
#include "covis/io/sequence.h"

namespace covis::io {

class NewestFrame {
 public:
  // unreadable: one image could not be decoded; gone: the camera is, until the next frame; failed: there is no other
  // frame.
  enum class Trouble { unreadable, gone, failed };
  // One of both, or none at the end.
  struct Taken {
    std::optional<Frame> frame = {};
    std::optional<std::pair<Trouble, Error>> trouble = {};
    int64_t dropped = 0;  // frames dropped until now
  };

  // Memory for the next frame: that of one which was dropped or given back, or none.
  Frame memory() {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return {};
    Frame frame = std::move(spare_.back());
    spare_.pop_back();
    return frame;
  }

  void put(Frame frame) {
    const std::lock_guard lock(mutex_);
    drop();
    frame_ = std::move(frame);
    frame_is_later_ = trouble_.has_value();
    changed_.notify_all();
  }

  // The gravest of the troubles that nobody took is kept.
  void report(Trouble trouble, Error error) {
    const std::lock_guard lock(mutex_);
    if (frame_ && frame_is_later_) drop();
    if (!trouble_ || trouble_->first < trouble) trouble_.emplace(trouble, std::move(error));
    frame_is_later_ = false;
    changed_.notify_all();
  }

  // Waits for something to take, but no longer than `stop` is zero; it may be null. A signal's handler can't notify, so
  // it is looked at every few milliseconds.
  Taken take(Frame recycled, const std::atomic<int>* stop) {
    std::unique_lock lock(mutex_);
    keep(std::move(recycled));
    while (!frame_ && !trouble_) {
      if (stop && *stop != 0) return {.dropped = dropped_};
      changed_.wait_for(lock, kLookInterval);
    }
    Taken taken{.dropped = dropped_};
    if (frame_ && !frame_is_later_) {
      taken.frame = std::exchange(frame_, std::nullopt);
    } else if (trouble_) {
      taken.trouble = std::exchange(trouble_, std::nullopt);
      frame_is_later_ = false;
    }
    return taken;
  }

 private:
  static constexpr std::chrono::milliseconds kLookInterval{20};
  static constexpr size_t kSpares = 2;  // beside the frame that waits and the one that is taken

  void keep(Frame frame) {
    if (!frame.image.empty() && spare_.size() < kSpares) spare_.push_back(std::move(frame));
  }
  void drop() {
    if (!frame_) return;
    ++dropped_;
    keep(std::move(*frame_));
    frame_.reset();
  }

  std::mutex mutex_;  // guards all of these
  std::condition_variable changed_;
  std::optional<Frame> frame_;
  std::optional<std::pair<Trouble, Error>> trouble_;
  bool frame_is_later_ = false;  // than the trouble
  int64_t dropped_ = 0;
  std::vector<Frame> spare_;
};

}  // namespace covis::io
