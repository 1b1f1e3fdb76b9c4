// SPDX-License-Identifier: Apache-2.0
// Messages as a terminal may show them. What they quote may come from files of strangers.
#pragma once

#include <string>
#include <string_view>

namespace covis {

// Messages of several lines say these. Ends of lines are shown as such here alone, because any other one was quoted.
inline constexpr std::string_view kCameraExample =
    "\n  width: 640\n  height: 480\n  fx: 525\n  fy: 525\n  cx: 320\n  cy: 240";
inline constexpr std::string_view kBagConversion =
    "\n  output_bags:\n  - {uri: converted, storage_id: sqlite3, all: true}\nand convert the bag with\n  ros2 bag "
    "convert -i ";

// Returns the text with its control characters, but for tabs, written as \x1b; of a very long text the beginning, which
// names file and line, and the end, which says what would be right.
std::string shown(std::string_view text);
// The same with all ends of lines, of a text that the program lays out.
std::string shown_lines(std::string_view text);

}  // namespace covis
