// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <utility>

#include "covis/core/quantile.h"
#include "covis/core/stamp_bounds.h"
#include "covis/core/time.h"

namespace covis::io {
namespace {

class RegularFile {
 public:
  static Result<RegularFile> open(const std::filesystem::path& file) {
    std::error_code none;
    if (std::filesystem::is_directory(file, none)) return fail(file.string() + ": it is a folder; a file is expected");
    // Without O_NONBLOCK it would wait for whoever writes to a pipe.
    RegularFile opened(file, ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (opened.handle_ < 0) return fail(file.string() + ": it can't be opened: " + std::strerror(errno));
    struct stat status {};
    if (fstat(opened.handle_, &status) != 0 || !S_ISREG(status.st_mode))
      return fail(file.string() + ": it is a pipe or a device; a regular file is expected");
    opened.size_ = static_cast<size_t>(status.st_size);
    return opened;
  }
  RegularFile(RegularFile&& other) noexcept
      : file_(std::move(other.file_)), handle_(std::exchange(other.handle_, -1)), size_(other.size_) {}
  RegularFile& operator=(RegularFile&&) = delete;
  ~RegularFile() {
    if (handle_ >= 0) close(handle_);
  }

  size_t size() const { return size_; }  // a hint: files of /proc have none
  // Reads into bytes from `at` on until they are full. Returns how many were read: fewer at the file's end.
  Result<size_t> read(std::string& bytes, size_t at) const {
    const size_t begin = at;
    while (at < bytes.size()) {
      const ssize_t n = ::read(handle_, bytes.data() + at, bytes.size() - at);
      if (n == 0) break;
      if (n > 0) {
        at += static_cast<size_t>(n);
      } else if (errno != EINTR) {
        return fail(file_.string() + ": it can't be read: " + std::strerror(errno));
      }
    }
    return at - begin;
  }

 private:
  RegularFile(std::filesystem::path file, int handle) : file_(std::move(file)), handle_(handle) {}

  std::filesystem::path file_;
  int handle_;
  size_t size_ = 0;
};

}  // namespace

std::filesystem::path normal_path(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(file, error);
  if (error) return file.lexically_normal();
  std::filesystem::path normal = std::filesystem::weakly_canonical(whole, error);
  return error ? whole.lexically_normal() : normal;
}

Result<std::string> read_text(const std::filesystem::path& file) {
  std::string text;
  if (auto read = read_bytes(file, text); !read) return tl::unexpected(read.error());
  if (is_wide_text(text)) return tl::unexpected(wide_text(file));
  remove_byte_order_mark(text);
  return text;
}

bool is_wide_text(std::string_view text) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) return true;
  const auto beside = [&](size_t zero, size_t letter) { return text[zero] == '\0' && text[letter] > ' '; };
  return text.size() > 1 && (beside(0, 1) || beside(1, 0));
}

Error wide_text(const std::filesystem::path& file) {
  return {file.string() + ": it is in UTF-16, or no text; save it in UTF-8"};
}

void remove_byte_order_mark(std::string& text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.erase(0, kMark.size());
}

bool is_regular(const std::filesystem::path& file) {
  std::error_code none;
  return std::filesystem::is_regular_file(file, none);
}

bool is_there(const std::filesystem::path& file) {
  std::error_code error;
  const bool there = std::filesystem::exists(file, error);
  if (error && error != std::errc::filename_too_long) throw std::filesystem::filesystem_error("status", file, error);
  return there;
}

Result<void> read_bytes(const std::filesystem::path& file, std::string& bytes) {
  const auto opened = RegularFile::open(file);
  if (!opened) return tl::unexpected(opened.error());
  const auto too_large = [&] {
    return fail(file.string() + ": it has more than " + std::to_string(kLargestFile >> 20) +
                " MiB, which is too much for such a file");
  };
  if (opened->size() > kLargestFile) return too_large();
  size_t done = 0;
  for (bytes.resize(opened->size() + 1);; bytes.resize(std::max<size_t>(4096, 2 * done))) {
    const auto read = opened->read(bytes, done);
    if (!read) return tl::unexpected(read.error());
    done += *read;
    if (done > kLargestFile) return too_large();
    if (done < bytes.size()) break;
  }
  bytes.resize(done);
  return {};
}

Result<std::string> read_head(const std::filesystem::path& file, size_t most) {
  const auto opened = RegularFile::open(file);
  if (!opened) return tl::unexpected(opened.error());
  std::string bytes(most, '\0');
  const auto read = opened->read(bytes, 0);
  if (!read) return tl::unexpected(read.error());
  bytes.resize(*read);
  return bytes;
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

// A decimal number as its digits and the number of digits before the point: "-1.25e1" is negative, "125", 2.
struct Decimal {
  bool negative = false;
  std::string digits;
  int64_t point = 0;
};

std::optional<Decimal> parse_decimal(std::string_view text) {
  if (!parse_double(text)) return std::nullopt;  // ensures a finite number for the code below
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
  const bool nanoseconds = decimal->point >= 17 || (plain && whole == WholeStamp::nanoseconds);
  const int64_t decimals = nanoseconds ? 0 : decimal->point == 16 ? 3 : decimal->point == 13 ? 6 : 9;
  const int64_t wanted = decimal->point + decimals;  // number of digits of the integer nanoseconds
  if (decimal->digits.empty() || wanted < 0) return 0;
  if (wanted > 19) return std::nullopt;  // does not fit 64 bits
  std::string& digits = decimal->digits;
  const auto kept = static_cast<size_t>(wanted);
  const bool up = digits.size() > kept && digits[kept] >= '5';
  digits.resize(kept, '0');
  int64_t stamp = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + kept, stamp);
  if (kept > 0 && error != std::errc()) return std::nullopt;
  if (up && stamp < std::numeric_limits<int64_t>::max()) ++stamp;
  if (!is_usable_stamp(stamp)) return std::nullopt;
  return decimal->negative ? -stamp : stamp;
}

namespace {

bool are_row_numbers(const std::vector<Timestamp>& stamps) {
  constexpr Timestamp kSecond = 1'000'000'000;
  if (stamps.size() < 2 || (stamps[0] != 0 && stamps[0] != kSecond)) return false;
  for (size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] != stamps[i - 1] + kSecond) return false;
  }
  return true;
}

bool rises(const std::vector<Timestamp>& stamps) {
  return std::adjacent_find(stamps.begin(), stamps.end(), std::greater_equal<>()) == stamps.end();
}

}  // namespace

bool is_rate_of_camera(double rate) { return rate >= 0.2 && rate <= 1000; }

std::optional<double> rate_of(const std::vector<Timestamp>& stamps) {
  if (stamps.size() < 2) return std::nullopt;
  std::vector<double> steps;
  for (size_t i = 1; i < stamps.size(); ++i) steps.push_back(to_seconds(stamps[i] - stamps[i - 1]));
  return 1 / quantile(std::move(steps), 0.5);
}

bool come_as_of_camera(const std::vector<Timestamp>& stamps) {
  const std::optional<double> rate = rate_of(stamps);
  return !rate || is_rate_of_camera(*rate);
}

namespace {

// A column of a list, read both as seconds and as whole nanoseconds until a row does not fit.
class StampColumn {
 public:
  void add(std::string_view text, int line) {
    const bool whole = text.find_first_not_of("+-0123456789") == text.npos;
    append(parse_stamp(text), seconds_);
    append(whole ? parse_stamp(text, WholeStamp::nanoseconds) : std::nullopt, nanoseconds_);
    if (unusable_line_ == 0 && !seconds_ && !nanoseconds_) unusable_line_ = line;
    numeric_ = numeric_ && parse_double(text);
    ++size_;
  }
  size_t size() const { return size_; }
  bool is_numeric() const { return numeric_; }
  // Returns the line of the row from which on no unit fits the column; 0: one fits all rows.
  int unusable_line() const { return unusable_line_; }
  // Returns the stamps of a column that is usable.
  const std::vector<Timestamp>& stamps() const {
    if (!seconds_) return *nanoseconds_;
    return nanoseconds_ && !come_as_of_camera(*seconds_) && come_as_of_camera(*nanoseconds_) ? *nanoseconds_
                                                                                             : *seconds_;
  }

 private:
  using Stamps = std::optional<std::vector<Timestamp>>;

  static void append(std::optional<Timestamp> stamp, Stamps& stamps) {
    if (!stamp) stamps.reset();
    if (stamps) stamps->push_back(*stamp);
  }

  Stamps seconds_{std::in_place}, nanoseconds_{std::in_place};
  size_t size_ = 0;
  int unusable_line_ = 0;
  bool numeric_ = true;
};

}  // namespace

Result<std::vector<Timestamp>> read_stamps(const std::filesystem::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  StampColumn first, second;
  std::string problem;
  const auto unusable = [&](std::string_view written, int line) {
    return place(file, line) + ": '" + std::string(written) + "' is not a stamp in seconds or whole nanoseconds";
  };
  std::string problem_behind;  // why the second column can't be used
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    first.add(parts.empty() ? line : parts[0], number);
    if (parts.size() > 1) second.add(parts[1], number);
    if (parts.size() > 1 && second.unusable_line() == number) problem_behind = unusable(parts[1], number);
    if (first.unusable_line() > 0) problem = unusable(line, number);
    return problem.empty();
  });
  if (!problem.empty()) return fail(problem);
  if (!are_row_numbers(first.stamps()) || second.size() != first.size()) return first.stamps();
  if (second.is_numeric() && !problem_behind.empty())
    return fail(problem_behind + ", and the numbers before it are those of the rows");
  return problem_behind.empty() && rises(second.stamps()) ? second.stamps() : first.stamps();
}

std::string stamp_text(Timestamp stamp) {
  const bool negative = stamp < 0;
  const auto magnitude = negative ? -static_cast<uint64_t>(stamp) : static_cast<uint64_t>(stamp);
  std::string fraction = std::to_string(magnitude % 1000000000u);
  fraction.insert(0, 9 - fraction.size(), '0');
  return (negative ? "-" : "") + std::to_string(magnitude / 1000000000u) + "." + fraction;
}

}  // namespace covis::io
