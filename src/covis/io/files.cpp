// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

namespace covis::io {

Result<std::string> read_text(const std::filesystem::path& file) {
  std::string text;
  if (auto read = read_bytes(file, text); !read) return tl::unexpected(read.error());
  return text;
}

Result<void> read_bytes(const std::filesystem::path& file, std::string& bytes) {
  std::error_code none;
  if (std::filesystem::is_directory(file, none)) return fail(file.string() + ": it is a folder, a file is wanted");
  const int handle = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (handle < 0) return fail(file.string() + ": it can't be opened: " + std::strerror(errno));
  // The size is a guess only: files of /proc and pipes have none.
  const auto guess = std::filesystem::file_size(file, none);
  bytes.resize(none ? 0 : static_cast<size_t>(guess) + 1);
  size_t done = 0;
  while (true) {
    if (done == bytes.size()) bytes.resize(std::max<size_t>(4096, 2 * done));
    const ssize_t n = read(handle, bytes.data() + done, bytes.size() - done);
    if (n == 0) break;
    if (n > 0) {
      done += static_cast<size_t>(n);
    } else if (errno != EINTR) {
      const int problem = errno;
      close(handle);
      return fail(file.string() + ": it can't be read: " + std::strerror(problem));
    }
  }
  close(handle);
  bytes.resize(done);
  return {};
}

namespace {

// All of the text into a file that is made or cut to nothing first; 0 or errno.
int write_all(const std::filesystem::path& file, std::string_view text, Durable durable) {
  const int handle = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (handle < 0) return errno;
  int problem = 0;
  for (size_t done = 0; done < text.size() && problem == 0;) {
    const ssize_t n = write(handle, text.data() + done, text.size() - done);
    if (n > 0) {
      done += static_cast<size_t>(n);
    } else if (n == 0 || errno != EINTR) {
      problem = n == 0 ? ENOSPC : errno;
    }
  }
  if (durable == Durable::yes && problem == 0 && fsync(handle) != 0) problem = errno;
  if (close(handle) != 0 && problem == 0) problem = errno;
  return problem;
}

// So that the new name is on the disk as well. Not every file system can; the file is whole all the same.
void sync_folder(const std::filesystem::path& folder) {
  const int handle = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return;
  fsync(handle);
  close(handle);
}

int write_and_rename(const std::filesystem::path& file, std::string_view text, Durable durable) {
  std::filesystem::path temporary = file;
  temporary += ".tmp" + std::to_string(getpid());
  int problem = write_all(temporary, text, durable);
  if (problem == 0 && rename(temporary.c_str(), file.c_str()) != 0) problem = errno;
  if (problem != 0) unlink(temporary.c_str());
  if (problem == 0 && durable == Durable::yes) sync_folder(file.parent_path());
  return problem;
}

}  // namespace

Result<void> write_text_atomically(const std::filesystem::path& file, std::string_view text, Durable durable) {
  std::error_code none;
  const auto status = std::filesystem::status(file, none);
  int problem = 0;
  if (std::filesystem::is_directory(status)) {
    problem = EISDIR;
  } else if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    problem = write_all(file, text, Durable::no);  // renaming over it would put a file in place of the device
  } else {
    const std::filesystem::path target = std::filesystem::weakly_canonical(file, none);
    problem = write_and_rename(none ? file : target, text, durable);
  }
  if (problem == 0) return {};
  return fail(file.string() + ": it can't be written: " + std::strerror(problem));
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> parts;
  const auto separator = [](char c) { return c == ' ' || c == '\t' || c == ',' || c == '\r'; };
  for (size_t i = 0; i < line.size();) {
    while (i < line.size() && separator(line[i])) ++i;
    const size_t start = i;
    while (i < line.size() && !separator(line[i])) ++i;
    if (i > start) parts.push_back(line.substr(start, i - start));
  }
  return parts;
}

std::optional<double> parse_double(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

namespace {

// A decimal number as digits, with the number of them before the point: "-1.25e1" is negative, "125", 2.
struct Decimal {
  bool negative = false;
  std::string digits;
  int64_t point = 0;
};

std::optional<Decimal> parse_decimal(std::string_view text) {
  if (!parse_double(text)) return std::nullopt;  // from here on it is known to be a finite number
  Decimal decimal;
  if (text.front() == '-' || text.front() == '+') {
    decimal.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  int64_t exponent = 0;
  if (const size_t e = text.find_first_of("eE"); e != std::string_view::npos) {
    std::string_view power = text.substr(e + 1);
    if (power.front() == '+') power.remove_prefix(1);
    std::from_chars(power.data(), power.data() + power.size(), exponent);
    text = text.substr(0, e);
  }
  const size_t dot = text.find('.');
  decimal.digits = text.substr(0, dot);
  decimal.point = static_cast<int64_t>(decimal.digits.size()) + exponent;
  if (dot != std::string_view::npos) decimal.digits += text.substr(dot + 1);
  const size_t zeros = std::min(decimal.digits.find_first_not_of('0'), decimal.digits.size());
  decimal.digits.erase(0, zeros);
  decimal.point -= static_cast<int64_t>(zeros);
  return decimal;
}

}  // namespace

std::optional<Timestamp> parse_stamp(std::string_view text, WholeStamp whole) {
  auto decimal = parse_decimal(text);
  if (!decimal) return std::nullopt;
  const bool plain = text.find_first_of(".eE") == std::string_view::npos;
  const bool nanoseconds = decimal->point >= 16 || (plain && whole == WholeStamp::nanoseconds);
  const int64_t wanted = decimal->point + (nanoseconds ? 0 : 9);  // digits of the whole nanoseconds
  if (decimal->digits.empty() || wanted < 0) return 0;
  if (wanted > 19) return std::nullopt;  // beyond 64 bits
  std::string& digits = decimal->digits;
  const auto kept = static_cast<size_t>(wanted);
  const bool up = digits.size() > kept && digits[kept] >= '5';
  digits.resize(kept, '0');
  int64_t stamp = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + kept, stamp);
  if (kept > 0 && error != std::errc()) return std::nullopt;
  if (up && stamp < std::numeric_limits<int64_t>::max()) ++stamp;
  return decimal->negative ? -stamp : stamp;
}

Result<std::vector<Timestamp>> read_stamps(const std::filesystem::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  std::vector<Timestamp> stamps;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    const auto stamp = parts.empty() ? std::nullopt : parse_stamp(parts.front());
    if (!stamp) {
      problem = place(file, number) + ": '" + std::string(line) + "' is not a stamp in seconds";
      return false;
    }
    stamps.push_back(*stamp);
    return true;
  });
  if (!problem.empty()) return fail(problem);
  return stamps;
}

std::string stamp_text(Timestamp stamp) {
  const bool negative = stamp < 0;
  const auto magnitude = negative ? -static_cast<uint64_t>(stamp) : static_cast<uint64_t>(stamp);
  std::string fraction = std::to_string(magnitude % 1000000000u);
  fraction.insert(0, 9 - fraction.size(), '0');
  return (negative ? "-" : "") + std::to_string(magnitude / 1000000000u) + "." + fraction;
}

}  // namespace covis::io
