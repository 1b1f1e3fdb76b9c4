// SPDX-License-Identifier: Apache-2.0
#include "covis/core/log.h"

#include <atomic>
#include <mutex>
#include <utility>

namespace covis {
namespace {

std::mutex& sink_mutex() {
  static std::mutex mutex;
  return mutex;
}

LogSink& sink() {
  static LogSink instance;
  return instance;
}

std::atomic<int> pauses = 0;

}  // namespace

void set_log_sink(LogSink new_sink) {
  // The sink before ends outside the lock: with it may end a program's own things, which wait for threads that log.
  {
    const std::lock_guard lock(sink_mutex());
    std::swap(sink(), new_sink);
  }
}

void log(LogLevel level, std::string_view message) {
  if (pauses > 0) return;
  const std::lock_guard lock(sink_mutex());
  try {
    if (sink()) sink()(level, message);
  } catch (...) {  // the program's own; the work that said something goes on
  }
}

LogPause::LogPause() { ++pauses; }
LogPause::~LogPause() { --pauses; }

}  // namespace covis
