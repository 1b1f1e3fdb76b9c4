// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/mapping_actor.h"

#include "covis/core/threads.h"

namespace covis {

MappingActor::MappingActor(SharedMap& map, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
    : mapper_(map, options, std::move(vocabulary)), interruptible_(options.realtime), thread_([this] { run(); }) {}

MappingActor::~MappingActor() {
  inbox_.close();
  outbox_.close();
  thread_.join();
}

void MappingActor::submit(Request request) {
  ++pending_;
  // Interrupting would make the result depend on timing: in real time only.
  if (++waiting_ > 1 && interruptible_) interrupt_ = true;
  inbox_.push(std::move(request));
}

MappingReport MappingActor::wait() {
  --pending_;
  return *outbox_.pop();
}

std::optional<MappingReport> MappingActor::poll() {
  if (outbox_.size() == 0) return std::nullopt;
  return wait();
}

void MappingActor::wait_idle() const {
  for (int waiting = waiting_.load(); waiting > 0; waiting = waiting_.load()) waiting_.wait(waiting);
}

void MappingActor::run() {
  lower_thread_priority();
  while (std::optional<Request> request = inbox_.pop()) {
    interrupt_ = interruptible_ && waiting_ > 1;
    MappingReport report;
    if (const auto* key_frame = std::get_if<KeyFrameRequest>(&*request)) {
      report = mapper_.process(*key_frame, &interrupt_);
    } else {
      report = mapper_.initialise(std::get<InitialMapRequest>(*request));
    }
    request.reset();
    --waiting_;
    waiting_.notify_all();
    outbox_.push(std::move(report));
  }
}

}  // namespace covis
