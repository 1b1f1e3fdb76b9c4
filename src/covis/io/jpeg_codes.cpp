// SPDX-License-Identifier: Apache-2.0
#include "covis/io/jpeg_codes.h"

namespace covis::io::jpeg {
namespace {

uint32_t rounded_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

struct Factors {
  uint32_t across = 1, down = 1;
};
Factors greatest(const Frame& frame) {
  Factors most;
  for (uint32_t c = 0; c < frame.count; ++c) {
    most.across = std::max(most.across, frame.components[c].across);
    most.down = std::max(most.down, frame.components[c].down);
  }
  return most;
}

}  // namespace

bool read_tables(std::string_view segment, Kind kind_of_ac, HuffmanTables& tables) {
  while (segment.size() >= 17) {
    const uint32_t head = byte_at(segment, 0);
    size_t count = 0;
    for (size_t k = 1; k <= 16; ++k) count += byte_at(segment, k);
    if ((head & 15) >= kIds || head >> 4 > 1 || segment.size() < 17 + count) return false;
    const Kind kind = head >> 4 ? kind_of_ac : Kind::dc;
    auto& all = head >> 4 ? tables.ac : tables.dc;
    if (!all[head & 15].make(kind, segment.substr(1, 16), segment.substr(17, count))) return false;
    segment.remove_prefix(17 + count);
  }
  return true;
}

bool read_frame(std::string_view segment, Frame& frame) {
  if (segment.size() < 6) return false;
  frame = {.width = short_at(segment, 3), .height = short_at(segment, 1), .count = byte_at(segment, 5)};
  if (frame.count < 1 || frame.count > frame.components.size() || segment.size() < 6 + 3 * frame.count) return false;
  for (uint32_t c = 0; c < frame.count; ++c) {
    const uint32_t factors = byte_at(segment, 7 + 3 * c), across = factors >> 4, down = factors & 15;
    if (across < 1 || across > 4 || down < 1 || down > 4) return false;
    frame.components[c] = {byte_at(segment, 6 + 3 * c), across, down};
  }
  // The blocks of one component alone are not grouped.
  if (frame.count == 1) frame.components[0].across = frame.components[0].down = 1;
  return true;
}

uint32_t Frame::units() const {
  const Factors most = greatest(*this);
  return rounded_up(width, 8 * most.across) * rounded_up(height, 8 * most.down);
}

uint32_t Frame::blocks(const Component& component) const {
  const Factors most = greatest(*this);
  return rounded_up(rounded_up(width * component.across, most.across), 8) *
         rounded_up(rounded_up(height * component.down, most.down), 8);
}

}  // namespace covis::io::jpeg
