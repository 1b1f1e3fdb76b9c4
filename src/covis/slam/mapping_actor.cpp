// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/mapping_actor.h"

namespace covis {

MappingActor::MappingActor(SharedMap& map, const SystemOptions& options)
    : mapper_(map, options), interruptible_(options.realtime), thread_([this] { run(); }) {}

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

MappingActor::Reply MappingActor::wait() {
  --pending_;
  return *outbox_.pop();
}

std::optional<MappingActor::Reply> MappingActor::poll() {
  if (outbox_.size() == 0) return std::nullopt;
  return wait();
}

void MappingActor::run() {
  while (std::optional<Request> request = inbox_.pop()) {
    interrupt_ = interruptible_ && waiting_ > 1;
    Reply reply;
    if (const auto* key_frame = std::get_if<KeyFrameRequest>(&*request)) {
      reply.frame = key_frame->frame;
      reply.report = mapper_.process(*key_frame, &interrupt_);
    } else {
      const auto& initial = std::get<InitialMapRequest>(*request);
      reply.frame = initial.second.frame;
      reply.report = mapper_.initialise(initial);
    }
    request.reset();
    --waiting_;
    outbox_.push(std::move(reply));
  }
}

}  // namespace covis
