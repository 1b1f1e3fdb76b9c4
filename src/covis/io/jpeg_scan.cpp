// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>

#include "covis/io/image_bytes.h"

namespace covis::io {
namespace {

constexpr size_t kIds = 4;  // tables of each class

// A code of a Huffman table: how many bits it and the value behind it take, and which coefficients it stands for.
struct Code {
  uint8_t bits = 0;  // of both; 0: there is no such code
  uint8_t step = 0;  // coefficients to the next one, or kEnd
};
constexpr uint8_t kEnd = 64;  // the rest of the block is zeros

enum class Kind { dc, ac };

// A Huffman table (T.81, section C): codes by the next 16 bits would take too much memory, so by the next nine, and
// longer codes by length.
class HuffmanTable {
 public:
  // counts: the numbers of codes of 1 to 16 bits. False: they are no code.
  bool make(Kind kind, std::string_view counts, std::string_view symbols) {
    kind_ = kind;
    symbols_ = symbols;
    fast_.fill({});
    uint32_t code = 0, index = 0;
    for (uint32_t length = 1; length <= 16; ++length) {
      const uint32_t count = static_cast<unsigned char>(counts[length - 1]);
      first_[length] = index - code;
      if (code + count > 1u << length) return false;
      for (uint32_t k = 0; length <= kFast && k < count; ++k) {
        const uint32_t from = (code + k) << (kFast - length);
        std::fill_n(fast_.begin() + from, 1u << (kFast - length), code_of(length, index + k));
      }
      code += count;
      index += count;
      end_[length] = code;
      code <<= 1;
    }
    return true;
  }
  bool known() const { return !symbols_.empty(); }

  // Finds the code that the 16 bits begin with.
  Code find(uint32_t bits) const {
    const Code code = fast_[bits >> (16 - kFast)];
    return code.bits != 0 ? code : find_long(bits);
  }

 private:
  static constexpr uint32_t kFast = 9;

  // The search begins with the first length, because short codes without meaning lead here as well.
  Code find_long(uint32_t bits) const {
    for (uint32_t length = 1; length <= 16; ++length) {
      const uint32_t code = bits >> (16 - length);
      if (code < end_[length]) return code_of(length, first_[length] + code);
    }
    return {};
  }
  Code code_of(uint32_t length, uint32_t index) const {
    const uint32_t symbol = static_cast<unsigned char>(symbols_[index]);
    if (kind_ == Kind::dc) return symbol > 16 ? Code{} : Code{static_cast<uint8_t>(length + symbol), 1};
    const uint32_t zeros = symbol >> 4, size = symbol & 15;
    return {static_cast<uint8_t>(length + size), size == 0 && zeros != 15 ? kEnd : static_cast<uint8_t>(zeros + 1)};
  }

  std::array<Code, 1 << kFast> fast_{};  // an entry without bits: the code is longer
  std::array<uint32_t, 17> first_{}, end_{};
  Kind kind_ = Kind::dc;
  std::string_view symbols_;
};

// Bits of compressed data, in which each byte 0xff is followed by 0, up to a marker.
class ScanBits {
 public:
  explicit ScanBits(std::string_view bytes) : bytes_(bytes) { find_plain(); }

  // The next 16 bits; behind the data they are 0.
  uint32_t peek() {
    if (count_ < 32) refill();
    return static_cast<uint32_t>(held_ >> 48);
  }
  // Valid after peek(), for 32 bits at most.
  void skip(uint32_t bits) {
    held_ <<= bits;
    count_ -= bits;
  }
  // True when more was skipped than there was.
  bool overrun() const { return count_ < 8 * behind_; }
  // Returns the number of bytes that follow, without the fill bytes before a marker. Valid without overrun.
  size_t bytes_left() const {
    size_t left = count_ / 8 - behind_;
    for (size_t i = at_; i < bytes_.size() && !is_marker(i); ++i) left += !is_fill(i);
    return left;
  }
  // Goes on behind the next marker, which must be a restart. False: there is none.
  bool restart() {
    while (at_ + 1 < bytes_.size() && !is_marker(at_)) ++at_;
    if (at_ + 1 >= bytes_.size()) return false;
    const auto marker = static_cast<unsigned char>(bytes_[at_ + 1]);
    at_ += 2;
    count_ = behind_ = 0;
    held_ = 0;
    find_plain();
    return marker >= 0xd0 && marker <= 0xd7;
  }

 private:
  bool is_marker(size_t i) const {
    return bytes_[i] == '\xff' && i + 1 < bytes_.size() && bytes_[i + 1] != 0 && bytes_[i + 1] != '\xff';
  }
  // Bytes 0xff may stand before that of a marker (T.81, B.1.1.2).
  bool is_fill(size_t i) const { return bytes_[i] == '\xff' && i + 1 < bytes_.size() && bytes_[i + 1] == '\xff'; }
  uint64_t byte(size_t i) const { return static_cast<unsigned char>(bytes_[i]); }

  void find_plain() { plain_ = std::min(bytes_.find('\xff', at_), bytes_.size()); }
  // Brings the bits that are held from fewer than 32 to at least as many.
  void refill() {
    if (at_ + 4 <= plain_) {
      held_ |= (byte(at_) << 24 | byte(at_ + 1) << 16 | byte(at_ + 2) << 8 | byte(at_ + 3)) << (32 - count_);
      at_ += 4;
      count_ += 32;
      return;
    }
    for (; count_ <= 56; count_ += 8) held_ |= next_byte() << (56 - count_);
  }
  uint64_t next_byte() {
    if (at_ < plain_) return byte(at_++);
    while (at_ < bytes_.size() && is_fill(at_)) ++at_;
    if (at_ >= bytes_.size() || is_marker(at_)) {
      ++behind_;
      return 0;
    }
    at_ += 2;  // 0xff and 0
    find_plain();
    return 0xff;
  }

  const std::string_view bytes_;
  size_t at_ = 0, plain_ = 0;        // no byte from the one to the other is 0xff
  uint64_t held_ = 0;                // the next bits, from the highest on
  uint32_t count_ = 0, behind_ = 0;  // bits held; bytes of them that lie behind the data
};

struct Component {
  uint32_t id = 0, blocks = 1;  // blocks in a unit of the scan
  uint32_t dc = 0, ac = 0;      // its tables
};

// The headers of a JPEG file with one scan of all components, sequential and Huffman-coded.
struct JpegHeaders {
  std::array<HuffmanTable, kIds> dc, ac;
  std::array<Component, 4> components;  // a scan has no more
  uint32_t count = 0;                   // components
  uint32_t units = 0, restart_interval = 0;
  std::string_view data;  // from the first byte of the scan on
};

uint32_t byte_at(std::string_view bytes, size_t i) { return static_cast<unsigned char>(bytes[i]); }
uint32_t short_at(std::string_view bytes, size_t i) { return byte_at(bytes, i) << 8 | byte_at(bytes, i + 1); }

bool read_tables(std::string_view segment, JpegHeaders& headers) {
  while (segment.size() >= 17) {
    const uint32_t head = byte_at(segment, 0);
    size_t count = 0;
    for (size_t k = 1; k <= 16; ++k) count += byte_at(segment, k);
    if ((head & 15) >= kIds || head >> 4 > 1 || segment.size() < 17 + count) return false;
    const Kind kind = head >> 4 ? Kind::ac : Kind::dc;
    auto& tables = kind == Kind::ac ? headers.ac : headers.dc;
    if (!tables[head & 15].make(kind, segment.substr(1, 16), segment.substr(17, count))) return false;
    segment.remove_prefix(17 + count);
  }
  return true;
}

bool read_frame(std::string_view segment, JpegHeaders& headers) {
  if (headers.count > 0 || segment.size() < 6) return false;
  headers.count = byte_at(segment, 5);
  if (headers.count > headers.components.size() || segment.size() < 6 + 3 * headers.count) return false;
  uint32_t across = 1, down = 1;
  for (uint32_t c = 0; c < headers.count; ++c) {
    const uint32_t factors = byte_at(segment, 7 + 3 * c), h = factors >> 4, v = factors & 15;
    if (h < 1 || h > 4 || v < 1 || v > 4) return false;
    across = std::max(across, h);
    down = std::max(down, v);
    headers.components[c] = {byte_at(segment, 6 + 3 * c), h * v};
  }
  if (headers.count == 1) {  // its blocks are not grouped then
    headers.components[0].blocks = 1;
    across = down = 1;
  }
  const auto units = [](uint32_t pixels, uint32_t blocks) { return (pixels + 8 * blocks - 1) / (8 * blocks); };
  headers.units = units(short_at(segment, 3), across) * units(short_at(segment, 1), down);
  return true;
}

bool read_scan(std::string_view segment, JpegHeaders& headers) {
  const uint32_t count = headers.count;
  if (count == 0 || segment.size() < 1 + 2 * count || byte_at(segment, 0) != count) return false;
  for (uint32_t c = 0; c < count; ++c) {
    Component& component = headers.components[c];
    if (byte_at(segment, 1 + 2 * c) != component.id) return false;
    const uint32_t tables = byte_at(segment, 2 + 2 * c);
    component.dc = tables >> 4;
    component.ac = tables & 15;
    if (component.dc >= kIds || component.ac >= kIds) return false;
    if (!headers.dc[component.dc].known() || !headers.ac[component.ac].known()) return false;
  }
  return true;
}

// False for files of another kind.
bool read_headers(std::string_view bytes, JpegHeaders& headers) {
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
    if (marker == 0xc4 && !read_tables(segment, headers)) return false;
    if ((marker == 0xc0 || marker == 0xc1) && !read_frame(segment, headers)) return false;
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

}  // namespace

bool jpeg_scan_is_whole(std::string_view bytes) {
  JpegHeaders headers;
  if (!read_headers(bytes, headers)) return true;
  ScanBits bits(headers.data);
  for (uint32_t unit = 0; unit < headers.units; ++unit) {
    if (headers.restart_interval > 0 && unit > 0 && unit % headers.restart_interval == 0 && !bits.restart())
      return false;
    for (uint32_t c = 0; c < headers.count; ++c) {
      const Component& component = headers.components[c];
      for (uint32_t block = 0; block < component.blocks; ++block) {
        if (!skip_block(headers.dc[component.dc], headers.ac[component.ac], bits)) return false;
      }
    }
    if (bits.overrun()) return false;
  }
  // Some encoders pad the data; a decoder that lost its place leaves much.
  return bits.bytes_left() <= 64 + headers.data.size() / 32;
}

}  // namespace covis::io
