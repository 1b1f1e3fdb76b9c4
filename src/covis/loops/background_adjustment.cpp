// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/background_adjustment.h"

#include <exception>
#include <string>
#include <utility>

#include "covis/core/failure_reason.h"
#include "covis/core/log.h"
#include "covis/core/time.h"

namespace covis {
namespace {

// Also where memory does not suffice to say so.
void report_given_up(const std::exception& error) noexcept {
  try {
    log(LogLevel::warning, "an adjustment of the map was given up: " + std::string(reason_of(error)));
  } catch (...) {
  }
}

}  // namespace

// The map does without a job that memory or threads do not suffice for.
void BackgroundAdjustment::start(std::unique_ptr<AdjustmentJob> job, int key_frames) {
  abandon();
  if (!job) return;
  job_ = std::move(job);
  key_frames_left_ = key_frames;
  interrupt_ = done_ = false;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::exception& error) {
    job_.reset();
    report_given_up(error);
  }
}

void BackgroundAdjustment::run() noexcept {
  const Stopwatch watch;
  try {
    solved_ = job_->run(interrupt_);
  } catch (const std::exception& error) {
    solved_ = false;
    report_given_up(error);
  }
  ms_ = watch.ms();
  done_ = true;
}

BackgroundAdjustment::Outcome BackgroundAdjustment::apply(SharedMap& map) {
  thread_.join();
  const std::unique_ptr<AdjustmentJob> job = std::move(job_);
  Outcome outcome{.kind = job->kind(), .solved = solved_, .ms = ms_};
  if (!solved_) return outcome;
  std::optional<KeyFrameMoves> applied = job->apply(map);
  outcome.applied = applied.has_value();
  if (applied) outcome.moves = std::move(*applied);
  return outcome;
}

void BackgroundAdjustment::abandon() {
  if (!job_) return;
  interrupt_ = true;
  thread_.join();
  job_.reset();
}

}  // namespace covis
