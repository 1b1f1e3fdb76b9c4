// SPDX-License-Identifier: Apache-2.0
// Messages of the library go to a sink that the program sets. Without a sink they are dropped; the library never
// prints.
#pragma once

#include <functional>
#include <string_view>

#include "covis/export.h"

namespace covis {

enum class LogLevel { debug, info, warning, error };
using LogSink = std::function<void(LogLevel, std::string_view)>;

// Sets the sink of the whole process; an empty one drops all messages. From any thread, at any time. The sink is called
// from any thread, one message at a time, while locks are held: it must not call the library. What it throws is
// dropped.
COVIS_API void set_log_sink(LogSink sink);

}  // namespace covis
