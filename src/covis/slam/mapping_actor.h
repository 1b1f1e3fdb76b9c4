// SPDX-License-Identifier: Apache-2.0
// The back end's thread: takes requests from an inbox, one after the other, and gives reports back in the same order
// (architecture.md, decision 5).
#pragma once

#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <thread>

#include "covis/core/blocking_queue.h"
#include "covis/slam/backend.h"

namespace covis {

class MappingActor {
 public:
  MappingActor(SharedMap& map, const BackendOptions& options, std::shared_ptr<const Vocabulary> vocabulary = nullptr);
  // Works off the inbox, then ends.
  ~MappingActor();

  // Each is answered by a report. Waits when the inbox is full.
  void submit(KeyFrameRequest request);
  void submit(InitialMapRequest request);
  // Waits until all requests are worked off, and the submap is erased. Throws as wait() does, and finish() too.
  void discard(uint32_t submap);
  // The map forgets the first `count` erased key frames. Does not wait for that, as nobody refers to them.
  void forget_erased(uint64_t count) { push(ForgetErased{count}); }
  // Waits until all requests are worked off, and the job in the background has ended and its result is applied. Returns
  // how that moved key frames.
  KeyFrameMoves finish();

  // The next report; waits for it. Call only when pending() > 0. Throws what ended the work on a request, as a lack of
  // memory: no request is worked on from then on, and it throws whenever it is called again.
  MappingReport wait();
  // The next report if it is there. Throws as wait() does.
  std::optional<MappingReport> poll();
  // Throws that too where it has happened, whatever is pending.
  void rethrow_failure() const;
  // Requests submitted whose report was not taken yet. Only the submitting thread may ask.
  int pending() const { return pending_; }
  // No request waits or is worked on.
  bool idle() const { return waiting_.load() == 0; }
  // Waits for that; reports stay where they are.
  void wait_idle() const;

 private:
  void push(BackendRequest request);
  std::optional<MappingReport> work_on(const BackendRequest& request);
  void run();

  static constexpr size_t kInbox = 3;

  Backend backend_;
  const bool interruptible_;
  BlockingQueue<BackendRequest> inbox_{kInbox};
  BlockingQueue<MappingReport> outbox_{kInbox + 2};  // room for all that can be pending
  std::atomic<int> waiting_{0};                      // submitted and not finished
  std::atomic<bool> interrupt_{false};               // another request waits
  std::atomic<bool> failed_{false};
  KeyFrameMoves finished_;      // the mapping thread's until it is idle
  std::exception_ptr failure_;  // written before failed_ is set and the outbox closed, read after
  int pending_ = 0;
  std::jthread thread_;
};

}  // namespace covis
