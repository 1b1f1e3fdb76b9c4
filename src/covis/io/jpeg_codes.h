// SPDX-License-Identifier: Apache-2.0
// The codes of JPEG files (ITU T.81): Huffman tables, the bits of compressed data, the segments that describe them. For
// .cpp files of this folder.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace covis::io::jpeg {

inline constexpr size_t kIds = 4;  // tables of each class

// A code of a Huffman table: how many bits it and the value behind it take, and which coefficients it stands for. Of a
// table of symbols: its own bits, and the symbol.
struct Code {
  uint8_t bits = 0;  // the sum of both; 0: there is no such code
  uint8_t step = 0;  // coefficients to the next one, or kEnd; or the symbol
};
inline constexpr uint8_t kEnd = 64;  // the rest of the block is zeros

enum class Kind { dc, ac, symbols };

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
    if (kind_ == Kind::symbols) return {static_cast<uint8_t>(length), static_cast<uint8_t>(symbol)};
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

inline uint32_t byte_at(std::string_view bytes, size_t i) { return static_cast<unsigned char>(bytes[i]); }
inline uint32_t short_at(std::string_view bytes, size_t i) { return byte_at(bytes, i) << 8 | byte_at(bytes, i + 1); }

struct HuffmanTables {
  std::array<HuffmanTable, kIds> dc, ac;
};
// Reads the tables of a DHT segment; those for other coefficients than the first become of the kind given. False: they
// are no tables.
bool read_tables(std::string_view segment, Kind kind_of_ac, HuffmanTables& tables);

// The size of an image and of its components, as a frame header (SOF) has them.
struct Frame {
  struct Component {
    uint32_t id = 0, across = 1, down = 1;  // blocks in a unit of a scan of all components
  };
  uint32_t width = 0, height = 0;            // pixels
  uint32_t count = 0;                        // components
  std::array<Component, 4> components = {};  // a scan has no more

  // Returns the number of units of a scan of all components.
  uint32_t units() const;
  // Returns the number of blocks of a scan of this component alone.
  uint32_t blocks(const Component& component) const;
};
// False: it is no frame, or one of more components.
bool read_frame(std::string_view segment, Frame& frame);

// The tables that a scan has for a component.
struct ScanTables {
  uint32_t dc = 0, ac = 0;
};
// Some encoders pad the data of a scan; a decoder that lost its place leaves much.
inline bool may_be_padding(size_t left, size_t all) { return left <= 64 + all / 32; }

}  // namespace covis::io::jpeg
