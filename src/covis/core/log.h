// SPDX-License-Identifier: Apache-2.0
// How the library says something; the sink is the program's (covis/log.h).
#pragma once

#include <string_view>

#include "covis/log.h"

namespace covis {

void log(LogLevel level, std::string_view message);

// While one lives, messages of the whole process are dropped: those of work that is tried out.
class LogPause {
 public:
  LogPause();
  ~LogPause();
  LogPause(const LogPause&) = delete;
  LogPause& operator=(const LogPause&) = delete;
};

}  // namespace covis
