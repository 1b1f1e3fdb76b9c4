// SPDX-License-Identifier: Apache-2.0
// Work of several stages, shared by the caller and a helper thread. Each takes the next task when it is free: a helper
// that gets no core holds nothing up but the task it has.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "covis/core/threads.h"

namespace covis {

class StagedWork {
 public:
  struct Stage {
    int tasks = 1;                  // at least one
    std::function<void(int)> task;  // called with 0 … tasks - 1, each once, in any thread
  };
  explicit StagedWork(std::vector<Stage> stages)
      : stages_(std::move(stages)), at_(stages_.size()), helper_([this](const std::stop_token& stop) { help(stop); }) {}

  // All tasks of a stage are done before the next begins, and of the last when it returns.
  void run() {
    other_cores_.keep(helper_);
    std::unique_lock lock(mutex_);
    at_ = 0;
    next_ = done_ = 0;
    changed_.notify_all();
    work(lock);
  }

 private:
  void help(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [&] { return at_ < stages_.size(); })) work(lock);
  }

  void work(std::unique_lock<std::mutex>& lock) {
    while (at_ < stages_.size()) {
      const size_t mine = at_;
      const Stage& stage = stages_[mine];
      if (next_ == stage.tasks) {
        changed_.wait(lock, [&] { return at_ != mine; });
        continue;
      }
      const int task = next_++;
      lock.unlock();
      stage.task(task);
      lock.lock();
      if (++done_ < stage.tasks) continue;
      ++at_;
      next_ = done_ = 0;
      changed_.notify_all();
    }
  }

  const std::vector<Stage> stages_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  size_t at_;                // stage; guarded by mutex_, as are:
  int next_ = 0, done_ = 0;  // its tasks begun and done
  OtherCores other_cores_;
  std::jthread helper_;  // last: it uses the rest
};

}  // namespace covis
