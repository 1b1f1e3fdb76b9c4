// SPDX-License-Identifier: Apache-2.0
// How the library says something; the sink is the program's (covis/log.h).
#pragma once

#include <string_view>

#include "covis/log.h"

namespace covis {

void log(LogLevel level, std::string_view message);

}  // namespace covis
