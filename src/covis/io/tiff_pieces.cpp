// SPDX-License-Identifier: Apache-2.0
// The compressed data of a TIFF, unpacked without their bytes: TIFF 6.0, sections 9 (PackBits) and 13 (LZW), and RFC
// 1950 and 1951 (deflate).
#include <algorithm>
#include <array>
#include <cstdint>

#include "covis/io/image_bytes.h"

namespace covis::io {
namespace {

uint32_t byte_of(std::string_view data, size_t at) { return static_cast<unsigned char>(data[at]); }

bool packbits_is_whole(std::string_view data, size_t expected) {
  size_t count = 0;
  for (size_t at = 0; at < data.size() && count < expected;) {
    const uint32_t head = byte_of(data, at++);
    const size_t bytes = head < 128 ? head + 1 : head == 128 ? 0 : 1;  // that follow
    if (bytes > data.size() - at) return false;
    count += head > 128 ? 257 - head : bytes;
    at += bytes;
  }
  return count >= expected;
}

bool lzw_is_whole(std::string_view data, size_t expected) {
  constexpr uint32_t kClear = 256, kEnd = 257, kFirst = 258, kMost = 4096 + 1024, kNone = kMost;
  if (data.size() >= 2 && data[0] == 0 && (data[1] & 1)) return true;  // the old kind
  std::array<uint32_t, kMost> lengths{};
  std::fill_n(lengths.begin(), kClear, 1);
  uint32_t held = 0, bits = 0, width = 9, next = kFirst, before = kNone;
  size_t count = 0;
  for (size_t at = 0; count < expected;) {
    for (; bits < width; bits += 8) {
      if (at == data.size()) return false;
      held = held << 8 | byte_of(data, at++);
    }
    bits -= width;
    const uint32_t code = held >> bits & ((1u << width) - 1);
    if (code == kEnd) return false;
    if (code == kClear) {
      width = 9;
      next = kFirst;
      before = kNone;
      continue;
    }
    if (before == kNone ? code > 255 : code > next || next >= kMost) return false;
    if (before != kNone) {
      lengths[next++] = lengths[before] + 1;
      if (next >= (1u << width) - 1 && width < 12) ++width;
    }
    count += lengths[code];
    before = code;
  }
  return true;
}

// Codes of deflate, by the number of codes of each length and their symbols in order (RFC 1951, section 3.2.2).
class DeflateCodes {
 public:
  // False: they are more than fit. lengths: of the codes of symbols 0, 1 …, in bits; 0: there is none.
  bool make(const uint8_t* lengths, size_t count) {
    counts_.fill(0);
    for (size_t k = 0; k < count; ++k) ++counts_[lengths[k]];
    counts_[0] = 0;
    std::array<uint16_t, 16> places{};
    int32_t left = 1;
    for (size_t bits = 1; bits < 16; ++bits) {
      left = 2 * left - counts_[bits];
      if (left < 0) return false;
      places[bits] = static_cast<uint16_t>(places[bits - 1] + counts_[bits - 1]);
    }
    for (size_t k = 0; k < count; ++k) {
      if (lengths[k] > 0) symbols_[places[lengths[k]]++] = static_cast<uint16_t>(k);
    }
    return true;
  }
  // bit(): the next one. kNone: there is no such code.
  template <class Bit>
  uint32_t next(Bit&& bit) const {
    int32_t code = 0, first = 0, index = 0;
    for (size_t bits = 1; bits < 16; ++bits) {
      code |= static_cast<int32_t>(bit());
      const int32_t count = counts_[bits];
      if (code - count < first) return symbols_[static_cast<size_t>(index + code - first)];
      index += count;
      first = 2 * (first + count);
      code *= 2;
    }
    return kNone;
  }
  static constexpr uint32_t kNone = 1000;

 private:
  std::array<uint16_t, 16> counts_{};
  std::array<uint16_t, 288> symbols_{};
};

// Walks through deflated data.
class Inflation {
 public:
  explicit Inflation(std::string_view data) : data_(data) {}

  bool gives(size_t expected) {
    for (bool last = false; count_ < expected && !last;) {
      last = bits(1) == 1;
      const uint32_t kind = bits(2);
      if (kind == 3 || !(kind == 0 ? stored() : (kind == 1 ? fixed() : dynamic()) && coded(expected))) return false;
    }
    return count_ >= expected && !overrun_;
  }

 private:
  uint32_t bits(uint32_t count) {
    uint32_t value = 0;
    for (uint32_t k = 0; k < count; ++k, ++at_) {
      overrun_ = overrun_ || at_ / 8 >= data_.size();
      if (!overrun_) value |= (byte_of(data_, at_ / 8) >> at_ % 8 & 1) << k;
    }
    return value;
  }

  bool stored() {
    at_ = (at_ + 7) / 8 * 8;
    const uint32_t length = bits(16);
    if ((bits(16) ^ length) != 0xffff || length > data_.size() - at_ / 8) return false;
    at_ += size_t{8} * length;
    count_ += length;
    return true;
  }

  bool fixed() {
    std::array<uint8_t, 288> lengths{};
    for (size_t k = 0; k < lengths.size(); ++k) lengths[k] = k < 144 ? 8 : k < 256 ? 9 : k < 280 ? 7 : 8;
    std::array<uint8_t, 30> far{};
    far.fill(5);
    return lengths_.make(lengths.data(), lengths.size()) && distances_.make(far.data(), far.size());
  }

  bool dynamic() {
    constexpr std::array<uint8_t, 19> kOrder = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
    const size_t literals = bits(5) + 257, distances = bits(5) + 1, count = bits(4) + 4;
    if (literals > 286 || distances > 30) return false;
    std::array<uint8_t, 320> lengths{};
    for (size_t k = 0; k < count; ++k) lengths[kOrder[k]] = static_cast<uint8_t>(bits(3));
    if (!lengths_.make(lengths.data(), kOrder.size())) return false;
    lengths.fill(0);
    for (size_t k = 0; k < literals + distances;) {
      const uint32_t symbol = lengths_.next([this] { return bits(1); });
      if (symbol > 18 || overrun_ || (symbol == 16 && k == 0)) return false;
      const size_t times = symbol < 16 ? 1 : symbol == 16 ? 3 + bits(2) : symbol == 17 ? 3 + bits(3) : 11 + bits(7);
      if (k + times > literals + distances) return false;
      const uint8_t length = symbol < 16 ? static_cast<uint8_t>(symbol) : symbol == 16 ? lengths[k - 1] : uint8_t{0};
      std::fill_n(lengths.begin() + static_cast<ptrdiff_t>(k), times, length);
      k += times;
    }
    return lengths_.make(lengths.data(), literals) && distances_.make(lengths.data() + literals, distances);
  }

  // Walks to the end of a block, or as far as bytes are expected.
  bool coded(size_t expected) {
    constexpr uint32_t kEnd = 256;
    const auto bit = [this] { return bits(1); };
    while (count_ < expected && !overrun_) {
      const uint32_t symbol = lengths_.next(bit);
      if (symbol == kEnd) return true;
      if (symbol > 285) return false;
      if (symbol < kEnd) {
        ++count_;
        continue;
      }
      const uint32_t k = symbol - 257, more = k < 8 || k == 28 ? 0 : k / 4 - 1;
      const size_t length = k == 28 ? 258 : (k < 8 ? k + 3 : ((4 + k % 4) << more) + 3) + bits(more);
      const uint32_t far = distances_.next(bit), further = far < 4 ? 0 : far / 2 - 1;
      if (far > 29) return false;
      const size_t distance = (far < 4 ? far : (2 + far % 2) << further) + 1 + bits(further);
      if (distance > count_) return false;
      count_ += length;
    }
    return !overrun_;
  }

  const std::string_view data_;
  size_t at_ = 0;     // bits
  size_t count_ = 0;  // bytes that came out
  bool overrun_ = false;
  DeflateCodes lengths_, distances_;
};

bool deflate_is_whole(std::string_view data, size_t expected) {
  constexpr size_t kHeader = 2;
  if (data.size() < kHeader || byte_of(data, 0) % 16 != 8 || (byte_of(data, 0) * 256 + byte_of(data, 1)) % 31 != 0)
    return false;
  return Inflation(data.substr(kHeader)).gives(expected);
}

}  // namespace

bool tiff_piece_is_whole(uint32_t compression, std::string_view data, size_t expected) {
  if (compression == 5) return lzw_is_whole(data, expected);
  if (compression == 32773) return packbits_is_whole(data, expected);
  if (compression == 8 || compression == 32946) return deflate_is_whole(data, expected);
  return data.size() >= expected;
}

}  // namespace covis::io
