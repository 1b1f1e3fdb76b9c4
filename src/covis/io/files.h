// SPDX-License-Identifier: Apache-2.0
// Reading of whole files, and parsing of numbers.
#pragma once

#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/failure_reason.h"
#include "covis/core/time.h"

namespace covis::io {

// Greatest size of a file that is read whole.
inline constexpr size_t kLargestFile = size_t{1} << 30;

// False for what cannot be read like a file: folders, pipes and devices, whose end may never come.
bool is_regular(const std::filesystem::path& file);
// True where there is something of this name. False for a name that is too long to be one; throws, as
// std::filesystem::exists() does, where nobody can say it.
bool is_there(const std::filesystem::path& file);
// The name by which places can be compared, also where nothing is there: absolute, and without links as far as these
// can be followed.
std::filesystem::path normal_path(const std::filesystem::path& file);
// Reads a regular file of text, without the byte order mark that may stand before it. Error: it is in UTF-16 or UTF-32.
Result<std::string> read_text(const std::filesystem::path& file);
// True where a text is in UTF-16 or UTF-32, by its byte order mark or its first characters.
bool is_wide_text(std::string_view text);
Error wide_text(const std::filesystem::path& file);
// Removes the byte order mark of UTF-8, which some editors write.
void remove_byte_order_mark(std::string& text);
// Reads a regular file, into reused memory.
Result<void> read_bytes(const std::filesystem::path& file, std::string& bytes);
// Reads the first `most` bytes of a regular file, all if it has fewer.
Result<std::string> read_head(const std::filesystem::path& file, size_t most);

inline Error no_memory(const std::filesystem::path& name) {
  return {name.string() + ": there is not enough memory for it"};
}
// Calls function(), which returns a Result, and makes an error of an exception that it throws. name: of the file, for
// messages.
template <class Function>
auto without_exceptions(const std::filesystem::path& name, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return tl::unexpected(no_memory(name));
  } catch (const std::exception& error) {
    return fail(name.string() + ": " + std::string(reason_of(error)));
  }
}

// Returns "FILE:LINE", as used in messages.
inline std::string place(const std::filesystem::path& file, int line) {
  return file.string() + ":" + std::to_string(line);
}
// Splits a line at blanks, tabs and commas.
std::vector<std::string_view> split(std::string_view line);
// Parses a finite number; nullopt when the text holds anything else.
std::optional<double> parse_double(std::string_view text);
// Parses a stamp to the nanosecond, in any notation: "1305031102.175304", "1.036e-01", "1403715273262142976". The unit
// is seconds, unless there are more digits before the point than plausible times have: 13 are milliseconds and 16
// microseconds, as times since 1970 have them now, and 17 or more nanoseconds. `whole` gives the unit of integers.
enum class WholeStamp { seconds, nanoseconds };
std::optional<Timestamp> parse_stamp(std::string_view text, WholeStamp whole = WholeStamp::seconds);
// True for a rate in Hz at which cameras give frames, from 0.2 to 1000.
bool is_rate_of_camera(double rate);
// Returns the rate in Hz of stamps' median step; nullopt where there are fewer than two.
std::optional<double> rate_of(const std::vector<Timestamp>& stamps);
// True for stamps whose rate is_rate_of_camera(), or of which there are fewer than two.
bool come_as_of_camera(const std::vector<Timestamp>& stamps);
// Reads a list of stamps, one per row: in the first column or, where that numbers the rows from 0 or 1 on and stamps
// that rise are behind it, in the second; numbers behind it that can't be stamps are an error. A column of whole
// numbers is in nanoseconds where it can't be in seconds, or would come as of no camera so and does as nanoseconds.
Result<std::vector<Timestamp>> read_stamps(const std::filesystem::path& file);
// Formats seconds with 9 decimals.
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
