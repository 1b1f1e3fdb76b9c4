// SPDX-License-Identifier: Apache-2.0
// Messages as a terminal may show them. What they quote may come from files of strangers.
#pragma once

#include <string>
#include <string_view>

namespace covis {

// Returns the text with its control characters, but for ends of lines and tabs, written as \x1b; of a very long text
// the beginning, which names file and line, and the end, which says what would be right.
std::string shown(std::string_view text);

}  // namespace covis
