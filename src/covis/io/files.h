// SPDX-License-Identifier: Apache-2.0
// Whole files in and out, and numbers from text.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/time.h"

namespace covis::io {

Result<std::string> read_text(const std::filesystem::path& file);

// Writes to a temporary name in the same folder and renames: the file is there whole or, on an error (a full disk, no
// right to write), as it was before.
Result<void> write_text_atomically(const std::filesystem::path& file, std::string_view text);

// The parts of a line between blanks, tabs or commas.
std::vector<std::string_view> split(std::string_view line);
// A finite number and nothing else.
std::optional<double> parse_double(std::string_view text);
// A stamp, exactly: seconds with a decimal point or exponent or fewer than 16 digits, else whole nanoseconds.
std::optional<Timestamp> parse_stamp(std::string_view text);
// Seconds with 9 decimals.
std::string stamp_text(Timestamp stamp);

// Calls visit(line, number) for each line that is neither blank nor a comment (#), numbered from 1, until it returns
// false.
template <class Visit>
void for_each_line(std::string_view text, Visit&& visit) {
  for (int number = 1; !text.empty(); ++number) {
    const size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    if (line.empty() || line.front() == '#') continue;
    if (!visit(line, number)) return;
  }
}

}  // namespace covis::io
