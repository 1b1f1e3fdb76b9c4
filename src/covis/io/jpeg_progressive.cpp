// SPDX-License-Identifier: Apache-2.0
// Progressive JPEG files: ITU T.81, sections G.1.2 and G.2.
#include <array>
#include <vector>

#include "covis/io/image_bytes.h"
#include "covis/io/jpeg_codes.h"

namespace covis::io::jpeg {
namespace {

struct Scan {
  uint32_t count = 0;                       // components
  std::array<uint32_t, 4> components = {};  // their places in the frame
  std::array<ScanTables, 4> used = {};      // their tables
  uint32_t first = 0, last = 0;             // coefficients
  bool refines = false;                     // each has its upper bits already
};

class Progressive {
 public:
  // Walks through the segments and scans. True for files of another kind.
  bool is_whole(std::string_view bytes) {
    for (size_t at = 2; at + 4 <= bytes.size();) {
      const uint32_t marker = byte_at(bytes, at + 1);
      if (byte_at(bytes, at) != 0xff || marker <= 1 || marker == 0xff || is_restart(marker)) {
        ++at;
        continue;
      }
      if (marker == kEndOfImage) break;
      const size_t length = short_at(bytes, at + 2);
      if (length < 2 || at + 2 + length > bytes.size()) return true;
      const std::string_view segment = bytes.substr(at + 4, length - 2);
      at += 2 + length;
      if (marker == 0xda) {
        const size_t end = end_of_data(bytes, at);
        if (!is_whole_scan(segment, bytes.substr(at, end + 2 - at))) return false;
        at = end;
      } else if (!read_segment(marker, segment)) {
        return true;
      }
    }
    return known_;
  }

 private:
  static constexpr uint32_t kEndOfImage = 0xd9;
  static bool is_restart(uint32_t marker) { return (marker & 0xf8) == 0xd0; }

  // Returns the place of the marker behind the data of a scan.
  static size_t end_of_data(std::string_view bytes, size_t at) {
    for (; (at = bytes.find('\xff', at)) != std::string_view::npos && at + 1 < bytes.size(); ++at) {
      const uint32_t marker = byte_at(bytes, at + 1);
      if (marker != 0 && marker != 0xff && !is_restart(marker)) return at;
    }
    return bytes.size();
  }

  // False: the decoder refuses it.
  bool read_segment(uint32_t marker, std::string_view segment) {
    if (marker == 0xc4) return read_tables(segment, Kind::symbols, tables_);
    if (marker == 0xdd && segment.size() >= 2) restart_interval_ = short_at(segment, 0);
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc8 && marker != 0xcc;
    if (!frame) return true;
    if (marker != 0xc2 || frame_.count > 0 || !read_frame(segment, frame_)) return false;
    for (uint32_t c = 0; c < frame_.count; ++c) set_[c].assign(frame_.blocks(frame_.components[c]), 0);
    return true;
  }

  // False: the decoder refuses it, or it has other tables than those of the file.
  bool read_scan(std::string_view segment, Scan& scan) const {
    scan.count = segment.empty() ? 0 : byte_at(segment, 0);
    if (scan.count < 1 || scan.count > frame_.count || segment.size() < 4 + 2 * scan.count) return false;
    for (uint32_t k = 0; k < scan.count; ++k) {
      uint32_t& c = scan.components[k];
      while (c < frame_.count && frame_.components[c].id != byte_at(segment, 1 + 2 * k)) ++c;
      const uint32_t tables = byte_at(segment, 2 + 2 * k);
      scan.used[k] = {tables >> 4, tables & 15};
      if (c == frame_.count || scan.used[k].dc >= kIds || scan.used[k].ac >= kIds) return false;
    }
    const size_t at = 1 + 2 * scan.count;
    scan.first = byte_at(segment, at);
    scan.last = byte_at(segment, at + 1);
    scan.refines = byte_at(segment, at + 2) >> 4 != 0;
    for (uint32_t k = 0; k < scan.count; ++k) {
      if (scan.first > 0 ? !tables_.ac[scan.used[k].ac].known() : !scan.refines && !tables_.dc[scan.used[k].dc].known())
        return false;
    }
    return scan.first == 0 ? scan.last == 0 : scan.count == 1 && scan.first <= scan.last && scan.last < 64;
  }

  bool is_whole_scan(std::string_view segment, std::string_view data) {
    Scan scan;
    if (!read_scan(segment, scan)) return known_ = true;
    const bool together = scan.count > 1;
    const uint32_t units = together ? frame_.units() : frame_.blocks(frame_.components[scan.components[0]]);
    ScanBits bits(data);
    zero_blocks_ = 0;
    for (uint32_t unit = 0; unit < units; ++unit) {
      if (restart_interval_ > 0 && unit > 0 && unit % restart_interval_ == 0) {
        if (!bits.restart()) return false;
        zero_blocks_ = 0;
      }
      for (uint32_t k = 0; k < scan.count; ++k) {
        const Frame::Component& component = frame_.components[scan.components[k]];
        const uint32_t blocks = together ? component.across * component.down : 1;
        for (uint32_t block = 0; block < blocks; ++block) {
          if (!skip_block(scan, k, unit, bits)) return false;
        }
      }
      if (bits.overrun()) return false;
    }
    if (scan.first == 0) known_ = true;
    return may_be_padding(bits.bytes_left(), data.size());
  }

  bool skip_block(const Scan& scan, uint32_t k, uint32_t unit, ScanBits& bits) {
    if (scan.first == 0) return skip_first(scan, tables_.dc[scan.used[k].dc], bits);
    const HuffmanTable& table = tables_.ac[scan.used[k].ac];
    uint64_t& set = set_[scan.components[k]][unit];
    return scan.refines ? skip_refinement(scan, table, set, bits) : skip_others(scan, table, set, bits);
  }

  // The first coefficient of a block.
  static bool skip_first(const Scan& scan, const HuffmanTable& table, ScanBits& bits) {
    const uint32_t next = bits.peek();
    const Code code = scan.refines ? Code{1, 1} : table.find(next);
    bits.skip(code.bits);
    return code.bits != 0;
  }

  // Reads the number of blocks from this one on whose rest is zero (T.81, figure G.3).
  void begin_zero_blocks(uint32_t length, ScanBits& bits) {
    zero_blocks_ = 1u << length;
    if (length == 0) return;
    zero_blocks_ += bits.peek() >> (16 - length);
    bits.skip(length);
  }

  // The upper bits of other coefficients of a block. set: by their bits, those that are not zero.
  bool skip_others(const Scan& scan, const HuffmanTable& table, uint64_t& set, ScanBits& bits) {
    for (uint32_t k = scan.first; zero_blocks_ == 0 && k <= scan.last; ++k) {
      const Code code = table.find(bits.peek());
      if (code.bits == 0) return false;
      bits.skip(code.bits);
      const uint32_t zeros = code.step >> 4, size = code.step & 15;
      if (size == 0 && zeros != 15) {
        begin_zero_blocks(zeros, bits);
        break;
      }
      k += zeros;
      if (k > scan.last) return false;
      if (size == 0) continue;
      bits.peek();
      bits.skip(size);
      set |= uint64_t{1} << k;
    }
    if (zero_blocks_ > 0) --zero_blocks_;
    return true;
  }

  // One more bit of the coefficients that are not zero, and those that become so (T.81, figure G.7).
  bool skip_refinement(const Scan& scan, const HuffmanTable& table, uint64_t& set, ScanBits& bits) {
    uint32_t k = scan.first;
    for (; zero_blocks_ == 0 && k <= scan.last; ++k) {
      const Code code = table.find(bits.peek());
      const uint32_t size = code.step & 15;
      uint32_t zeros = code.step >> 4;
      if (code.bits == 0 || size > 1) return false;
      bits.skip(code.bits + size);
      if (size == 0 && zeros != 15) {
        begin_zero_blocks(zeros, bits);
        break;
      }
      for (; k <= scan.last; ++k) {
        if (set >> k & 1) {
          skip_bit(bits);
        } else if (zeros-- == 0) {
          break;
        }
      }
      if (size == 0) continue;
      if (k > scan.last) return false;
      set |= uint64_t{1} << k;
    }
    if (zero_blocks_ == 0) return true;
    --zero_blocks_;
    for (; k <= scan.last; ++k) {
      if (set >> k & 1) skip_bit(bits);
    }
    return true;
  }

  static void skip_bit(ScanBits& bits) {
    bits.peek();
    bits.skip(1);
  }

  HuffmanTables tables_;
  Frame frame_;
  uint32_t restart_interval_ = 0;
  uint32_t zero_blocks_ = 0;                       // from here on whose other coefficients of the scan are zero
  std::array<std::vector<uint64_t>, 4> set_ = {};  // by component and block: bits of coefficients that are not zero
  bool known_ = false;                             // there was a scan of first coefficients
};

}  // namespace
}  // namespace covis::io::jpeg

namespace covis::io {

bool progressive_jpeg_is_whole(std::string_view bytes) { return jpeg::Progressive().is_whole(bytes); }

}  // namespace covis::io
