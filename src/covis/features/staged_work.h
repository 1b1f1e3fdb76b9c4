// SPDX-License-Identifier: Apache-2.0
// Work in several stages, shared by the caller and a helper thread. Each takes the next task when it is free, so a
// helper that gets no core delays only the task it holds.
#pragma once

#include <condition_variable>
#include <exception>
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

  // Runs all tasks of a stage before the next stage begins; returns when the last stage is done. Throws what a task
  // threw first, in whichever thread; tasks after that are not run.
  void run() {
    other_cores_.keep(helper_);
    std::unique_lock lock(mutex_);
    at_ = 0;
    next_ = done_ = 0;
    changed_.notify_all();
    work(lock);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
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
      if (!failure_) {
        lock.unlock();
        std::exception_ptr failure;
        try {
          stage.task(task);
        } catch (...) {
          failure = std::current_exception();
        }
        lock.lock();
        if (failure && !failure_) failure_ = failure;
      }
      if (++done_ < stage.tasks) continue;
      ++at_;
      next_ = done_ = 0;
      changed_.notify_all();
    }
  }

  const std::vector<Stage> stages_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  size_t at_;                // current stage; guarded by mutex_, like the next lines
  int next_ = 0, done_ = 0;  // next task of the stage, and number of finished ones
  std::exception_ptr failure_;
  OtherCores other_cores_;
  std::jthread helper_;  // last member: its thread uses the others
};

}  // namespace covis
