// SPDX-License-Identifier: Apache-2.0
// Whole files read, and numbers from text.
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
// The same into memory that is used again.
Result<void> read_bytes(const std::filesystem::path& file, std::string& bytes);

// "FILE:LINE", as messages name a line.
inline std::string place(const std::filesystem::path& file, int line) {
  return file.string() + ":" + std::to_string(line);
}
// The parts of a line between blanks, tabs or commas.
std::vector<std::string_view> split(std::string_view line);
// A finite number and nothing else.
std::optional<double> parse_double(std::string_view text);
// A stamp, to the nanosecond, however it is written: "1305031102.175304", "1.036e-01", "1403715273262142976". Seconds,
// unless there are 16 digits or more before the point: no clock counts so many seconds, those are nanoseconds. `whole`
// says what a plain whole number of fewer digits means.
enum class WholeStamp { seconds, nanoseconds };
std::optional<Timestamp> parse_stamp(std::string_view text, WholeStamp whole = WholeStamp::seconds);
// A list of stamps, one a row in its first column, in seconds.
Result<std::vector<Timestamp>> read_stamps(const std::filesystem::path& file);
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
