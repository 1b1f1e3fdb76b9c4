// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

namespace covis::io {

Result<std::string> read_text(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) return fail(file.string() + ": it is a folder, a file is wanted");
  std::ifstream in(file, std::ios::binary);
  if (!in) return fail(file.string() + ": it can't be opened: " + std::strerror(errno));
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad()) return fail(file.string() + ": it can't be read");
  return std::move(text).str();
}

Result<void> write_text_atomically(const std::filesystem::path& file, std::string_view text) {
  std::filesystem::path temporary = file;
  temporary += ".tmp" + std::to_string(getpid());
  const int handle = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (handle < 0) return fail(file.string() + ": it can't be written: " + std::strerror(errno));
  int problem = 0;
  for (size_t done = 0; done < text.size() && problem == 0;) {
    const ssize_t n = write(handle, text.data() + done, text.size() - done);
    if (n > 0) {
      done += static_cast<size_t>(n);
    } else if (n == 0 || errno != EINTR) {
      problem = n == 0 ? ENOSPC : errno;
    }
  }
  if (close(handle) != 0 && problem == 0) problem = errno;
  if (problem == 0 && rename(temporary.c_str(), file.c_str()) != 0) problem = errno;
  if (problem == 0) return {};
  unlink(temporary.c_str());
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

std::optional<Timestamp> parse_stamp(std::string_view text) {
  const auto value = parse_double(text);
  if (!value) return std::nullopt;
  if (text.find_first_of("eE") != std::string_view::npos) return from_seconds(*value);
  const bool negative = text.front() == '-';
  if (negative || text.front() == '+') text.remove_prefix(1);
  const size_t dot = text.find('.');
  const std::string_view whole = text.substr(0, dot);
  std::string digits(whole);
  if (dot == std::string_view::npos && whole.size() >= 16) {
    // nanoseconds already
  } else {
    std::string fraction(dot == std::string_view::npos ? "" : text.substr(dot + 1));
    fraction.resize(9, '0');
    digits += fraction;
  }
  int64_t stamp = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), stamp);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return negative ? -stamp : stamp;
}

std::string stamp_text(Timestamp stamp) {
  const bool negative = stamp < 0;
  const auto magnitude = negative ? -static_cast<uint64_t>(stamp) : static_cast<uint64_t>(stamp);
  std::string fraction = std::to_string(magnitude % 1000000000u);
  fraction.insert(0, 9 - fraction.size(), '0');
  return (negative ? "-" : "") + std::to_string(magnitude / 1000000000u) + "." + fraction;
}

}  // namespace covis::io
