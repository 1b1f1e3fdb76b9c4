// SPDX-License-Identifier: Apache-2.0
// The library's messages go to a sink that the program sets. Without a sink they are dropped; the library never prints.
#pragma once

#include <functional>
#include <string_view>

namespace covis {

enum class LogLevel { debug, info, warning, error };
using LogSink = std::function<void(LogLevel, std::string_view)>;

// Must be called before threads start. The sink is called from any thread, one message at a time, under locks: it must
// not call the system.
void set_log_sink(LogSink sink);
void log(LogLevel level, std::string_view message);

}  // namespace covis
