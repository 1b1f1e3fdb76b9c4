// SPDX-License-Identifier: Apache-2.0
#include "covis/core/message_text.h"

#include <cstdio>

namespace covis {
namespace {

constexpr size_t kMostShown = 2500, kBegin = 1500, kEnd = 800;  // bytes

// A character of UTF-8 has one byte that does not continue another.
bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

std::string shortened(std::string_view text) {
  if (text.size() <= kMostShown) return std::string(text);
  size_t begin = kBegin, end = text.size() - kEnd;
  while (begin > 0 && continues(text[begin])) --begin;
  while (end < text.size() && continues(text[end])) ++end;
  return std::string(text.substr(0, begin)) + " … " + std::string(text.substr(end));
}

bool is_control(unsigned char c) { return (c < ' ' && c != '\t') || c == 0x7f; }

// Escapes the control characters of one line.
std::string escaped(std::string_view all) {
  std::string safe;
  for (size_t i = 0; i < all.size(); ++i) {
    const auto c = static_cast<unsigned char>(all[i]);
    // U+0080 to U+009F begin commands of terminals, too.
    const bool two = c == 0xc2 && i + 1 < all.size() && static_cast<unsigned char>(all[i + 1]) < 0xa0;
    if (!is_control(c) && !two) {
      safe += all[i];
      continue;
    }
    char escaped[8];
    std::snprintf(escaped, sizeof escaped, "\\x%02x", two ? static_cast<unsigned char>(all[++i]) : c);
    safe += escaped;
  }
  return safe;
}

}  // namespace

std::string shown(std::string_view text) {
  const std::string all = shortened(text);
  std::string_view rest = all;
  while (rest.ends_with('\n')) rest.remove_suffix(1);  // as what some libraries say ends
  std::string safe;
  while (true) {
    size_t begin = std::string_view::npos, size = 0;
    for (const std::string_view own : {kCameraExample, kBagConversion}) {
      if (const size_t at = rest.find(own); at < begin) begin = at, size = own.size();
    }
    safe += escaped(rest.substr(0, begin));
    if (begin == std::string_view::npos) return safe;
    safe += rest.substr(begin, size);
    rest.remove_prefix(begin + size);
  }
}

std::string shown_lines(std::string_view text) {
  const std::string all = shortened(text);
  std::string safe;
  for (size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
    end = all.find('\n', begin);
    safe += escaped(std::string_view(all).substr(begin, end - begin));
    if (end != std::string::npos) safe += '\n';
  }
  return safe;
}

}  // namespace covis
