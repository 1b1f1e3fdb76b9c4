// SPDX-License-Identifier: Apache-2.0
// The mapper's thread: takes requests from an inbox, one after the other, and gives reports back in the same order
// (architecture.md, decision 5).
#pragma once

#include <atomic>
#include <optional>
#include <thread>
#include <variant>

#include "covis/core/blocking_queue.h"
#include "covis/slam/mapper.h"

namespace covis {

class MappingActor {
 public:
  MappingActor(SharedMap& map, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary = nullptr);
  // Works off what is in the inbox, then ends.
  ~MappingActor();

  using Request = std::variant<KeyFrameRequest, InitialMapRequest>;
  // Waits when the inbox is full.
  void submit(Request request);
  // The next report; waits for it. Call only when pending() > 0.
  MappingReport wait();
  // The next report if it is there.
  std::optional<MappingReport> poll();
  // Requests submitted whose report was not taken yet. Only the submitting thread may ask.
  int pending() const { return pending_; }
  // No request waits or is worked on.
  bool idle() const { return waiting_.load() == 0; }
  // Waits for that; reports stay where they are.
  void wait_idle() const;

  // Only while nothing is pending.
  Mapper& mapper() { return mapper_; }

 private:
  void run();

  static constexpr size_t kInbox = 3;

  Mapper mapper_;
  const bool interruptible_;
  BlockingQueue<Request> inbox_{kInbox};
  BlockingQueue<MappingReport> outbox_{kInbox + 2};  // room for all that can be pending
  std::atomic<int> waiting_{0};                      // submitted and not finished
  std::atomic<bool> interrupt_{false};               // another request waits
  int pending_ = 0;
  std::jthread thread_;
};

}  // namespace covis
