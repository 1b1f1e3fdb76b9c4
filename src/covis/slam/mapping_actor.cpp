// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/mapping_actor.h"

#include <utility>

#include "covis/core/threads.h"

namespace covis {

MappingActor::MappingActor(SharedMap& map, const BackendOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
    : backend_(map, options, std::move(vocabulary)),
      interruptible_(options.schedule == Schedule::realtime),
      thread_([this] { run(); }) {}

MappingActor::~MappingActor() {
  inbox_.close();
  outbox_.close();
  thread_.join();
}

void MappingActor::push(BackendRequest request) {
  // Interrupting would make the result depend on timing: in real time only.
  if (++waiting_ > 1 && interruptible_) interrupt_ = true;
  try {
    inbox_.push(std::move(request));
  } catch (...) {  // a lack of memory
    --waiting_;
    throw;
  }
}

void MappingActor::submit(KeyFrameRequest request) {
  push(std::move(request));
  ++pending_;
}

void MappingActor::submit(InitialMapRequest request) {
  push(std::move(request));
  ++pending_;
}

void MappingActor::discard(uint32_t submap) {
  push(DiscardSubmap{submap});
  wait_idle();
  rethrow_failure();
}

KeyFrameMoves MappingActor::finish() {
  push(FinishAdjustment{});
  wait_idle();
  rethrow_failure();
  return std::exchange(finished_, {});
}

MappingReport MappingActor::wait() {
  std::optional<MappingReport> report = outbox_.pop();
  if (!report) std::rethrow_exception(failure_);
  --pending_;
  return std::move(*report);
}

std::optional<MappingReport> MappingActor::poll() {
  if (outbox_.size() == 0 && !failed_) return std::nullopt;
  return wait();
}

void MappingActor::wait_idle() const {
  for (int waiting = waiting_.load(); waiting > 0; waiting = waiting_.load()) waiting_.wait(waiting);
}

void MappingActor::rethrow_failure() const {
  if (failed_) std::rethrow_exception(failure_);
}

std::optional<MappingReport> MappingActor::work_on(const BackendRequest& request) {
  if (const auto* key_frame = std::get_if<KeyFrameRequest>(&request)) return backend_.process(*key_frame, &interrupt_);
  if (const auto* initial = std::get_if<InitialMapRequest>(&request)) return backend_.initialise(*initial);
  if (const auto* discarded = std::get_if<DiscardSubmap>(&request)) backend_.discard(discarded->submap);
  if (const auto* erased = std::get_if<ForgetErased>(&request)) backend_.forget_erased(erased->count);
  if (std::holds_alternative<FinishAdjustment>(request)) finished_ = backend_.finish();
  return std::nullopt;
}

void MappingActor::run() {
  lower_thread_priority();
  const auto attempt = [this](const auto& part) {
    try {
      part();
    } catch (...) {
      failure_ = std::current_exception();
      failed_ = true;
      outbox_.close();
    }
  };
  while (std::optional<BackendRequest> request = inbox_.pop()) {
    // Cleared before it looks: a request pushed meanwhile sets it again.
    interrupt_ = false;
    if (interruptible_ && waiting_ > 1) interrupt_ = true;
    std::optional<MappingReport> report;
    attempt([&] {
      if (!failed_) report = work_on(*request);
    });
    request.reset();
    --waiting_;
    waiting_.notify_all();
    attempt([&] {
      if (report) outbox_.push(std::move(*report));
    });
  }
}

}  // namespace covis
