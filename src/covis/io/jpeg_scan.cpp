// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdint>

#include "covis/io/image_bytes.h"
#include "covis/io/jpeg_codes.h"

namespace covis::io::jpeg {
namespace {

// The headers of a JPEG file with one scan of all components, sequential and Huffman-coded.
struct Headers {
  HuffmanTables tables;
  Frame frame;
  std::array<ScanTables, 4> used = {};  // by component
  uint32_t restart_interval = 0;
  std::string_view data;  // from the first byte of the scan on
};

bool read_scan(std::string_view segment, Headers& headers) {
  const uint32_t count = headers.frame.count;
  if (count == 0 || segment.size() < 1 + 2 * count || byte_at(segment, 0) != count) return false;
  for (uint32_t c = 0; c < count; ++c) {
    if (byte_at(segment, 1 + 2 * c) != headers.frame.components[c].id) return false;
    ScanTables& used = headers.used[c];
    used = {byte_at(segment, 2 + 2 * c) >> 4, byte_at(segment, 2 + 2 * c) & 15};
    if (used.dc >= kIds || used.ac >= kIds) return false;
    if (!headers.tables.dc[used.dc].known() || !headers.tables.ac[used.ac].known()) return false;
  }
  return true;
}

// False for files of another kind.
bool read_headers(std::string_view bytes, Headers& headers) {
  for (size_t at = 2; at + 4 <= bytes.size() && bytes[at] == '\xff';) {
    const uint32_t marker = byte_at(bytes, at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    const size_t length = short_at(bytes, at + 2);
    if (length < 2 || at + 2 + length > bytes.size()) return false;
    const std::string_view segment = bytes.substr(at + 4, length - 2);
    at += 2 + length;
    if (marker == 0xc4 && !read_tables(segment, Kind::ac, headers.tables)) return false;
    if ((marker == 0xc0 || marker == 0xc1) && (headers.frame.count > 0 || !read_frame(segment, headers.frame)))
      return false;
    if (marker == 0xdd && segment.size() >= 2) headers.restart_interval = short_at(segment, 0);
    if (marker == 0xda) {
      headers.data = bytes.substr(at);
      return read_scan(segment, headers);
    }
  }
  return false;
}

// Walks through the 64 coefficients of a block.
bool skip_block(const HuffmanTable& dc, const HuffmanTable& ac, ScanBits& bits) {
  for (uint32_t k = 0; k < 64;) {
    const Code code = (k == 0 ? dc : ac).find(bits.peek());
    if (code.bits == 0) return false;
    bits.skip(code.bits);
    if (code.step == kEnd) return true;
    k += code.step;
    if (k > 64) return false;
  }
  return true;
}

// Walks through the blocks of a component in a unit of the scan.
bool skip_component(const Headers& headers, uint32_t c, ScanBits& bits) {
  const Frame::Component& component = headers.frame.components[c];
  const HuffmanTables& tables = headers.tables;
  for (uint32_t block = 0; block < component.across * component.down; ++block) {
    if (!skip_block(tables.dc[headers.used[c].dc], tables.ac[headers.used[c].ac], bits)) return false;
  }
  return true;
}

bool is_whole(const Headers& headers) {
  ScanBits bits(headers.data);
  for (uint32_t unit = 0, units = headers.frame.units(); unit < units; ++unit) {
    if (headers.restart_interval > 0 && unit > 0 && unit % headers.restart_interval == 0 && !bits.restart())
      return false;
    for (uint32_t c = 0; c < headers.frame.count; ++c) {
      if (!skip_component(headers, c, bits)) return false;
    }
    if (bits.overrun()) return false;
  }
  return may_be_padding(bits.bytes_left(), headers.data.size());
}

}  // namespace
}  // namespace covis::io::jpeg

namespace covis::io {

bool jpeg_scan_is_whole(std::string_view bytes) {
  jpeg::Headers headers;
  return !jpeg::read_headers(bytes, headers) || jpeg::is_whole(headers);
}

}  // namespace covis::io
