// SPDX-License-Identifier: Apache-2.0
// The next frame of a recording or a camera that can be read: one that can't is left out with a warning, as `covis run`
// does, and a camera that is gone is waited for.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <optional>

#include "covis/core/error.h"
#include "covis/core/log.h"
#include "covis/io/sequence.h"

namespace covis::python {

// Waits in a thread of its own where that may take forever, and calls `interrupted` meanwhile, which says whether to
// give up; then there is no frame. `stop`: that of the camera's SequenceOptions.
template <class Interrupted>
Result<std::optional<io::Frame>> next_or_none(io::Sequence& sequence, std::atomic<int>& stop,
                                              const Interrupted& interrupted) {
  constexpr std::chrono::milliseconds kSlice{50};
  if (sequence.kind() != io::SequenceKind::camera) return sequence.next();
  auto next = std::async(std::launch::async, [&] { return sequence.next(); });
  while (next.wait_for(kSlice) != std::future_status::ready) {
    if (interrupted()) stop = 1;
  }
  stop = 0;
  return next.get();
}

// The end: nullopt. Error: there will be no other frame. `unreadable` counts those that were left out.
template <class Interrupted>
Result<std::optional<io::Frame>> next_readable(io::Sequence& sequence, std::atomic<int>& stop,
                                               std::atomic<int64_t>& unreadable, const Interrupted& interrupted) {
  for (;;) {
    auto next = next_or_none(sequence, stop, interrupted);
    const io::LiveStatus::State state = sequence.live().state;
    if (next || state == io::LiveStatus::State::failed) return next;
    if (interrupted()) return std::optional<io::Frame>();  // a sink of Python's must not be called then
    if (state == io::LiveStatus::State::there) ++unreadable;
    log(LogLevel::warning, next.error().message);
    if (interrupted()) return std::optional<io::Frame>();
  }
}

}  // namespace covis::python
