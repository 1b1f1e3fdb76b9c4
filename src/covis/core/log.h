// SPDX-License-Identifier: Apache-2.0
// The library's messages go to a sink the program sets; without one they are dropped. The library never prints.
#pragma once

#include <functional>
#include <string_view>

namespace covis {

enum class LogLevel { debug, info, warning, error };
using LogSink = std::function<void(LogLevel, std::string_view)>;

// Set before threads start. The sink is called under a lock, one message at a time, from any thread.
void set_log_sink(LogSink sink);
void log(LogLevel level, std::string_view message);

}  // namespace covis
