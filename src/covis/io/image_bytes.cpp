// SPDX-License-Identifier: Apache-2.0
#include "covis/io/image_bytes.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace covis::io {
namespace {

// Reads whole numbers at places of a file; 0 behind its end.
class Numbers {
 public:
  enum class Order { big, little };
  explicit Numbers(std::string_view bytes, Order order = Order::big) : bytes_(bytes), order_(order) {}

  uint32_t operator()(size_t at, size_t length) const {
    uint32_t value = 0;
    if (at > bytes_.size() || length > bytes_.size() - at) return 0;
    for (size_t k = 0; k < length; ++k) {
      const size_t i = order_ == Order::big ? at + k : at + length - 1 - k;
      value = value << 8 | static_cast<unsigned char>(bytes_[i]);
    }
    return value;
  }

 private:
  const std::string_view bytes_;
  const Order order_;
};

std::string too_short(std::string_view bytes) {
  return "the image file is cut short (" + std::to_string(bytes.size()) + " bytes)";
}

std::optional<std::string> problem_of_size(uint32_t width, uint32_t height) {
  constexpr uint32_t kMost = kLargestImageSide;
  if (width >= 1 && height >= 1 && width <= kMost && height <= kMost) return std::nullopt;
  return "its header says that the image is " + std::to_string(width) + "x" + std::to_string(height) +
         "; sides of 1 to " + std::to_string(kMost) + " pixels can be read";
}

// The PNG specification, annex D, bit by bit: for short pieces.
uint32_t crc32(std::string_view bytes) {
  uint32_t crc = ~0u;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return ~crc;
}

// The PNG specification, section 11.2.2. The decoder would tell of these on stderr.
bool is_png_header(uint32_t depth, uint32_t colour, uint32_t compression, uint32_t filter, uint32_t interlace) {
  const bool power = depth >= 1 && depth <= 16 && (depth & (depth - 1)) == 0;
  const bool fits =
      colour == 0 || (colour == 3 ? depth <= 8 : (colour == 2 || colour == 4 || colour == 6) && depth >= 8);
  return power && fits && compression == 0 && filter == 0 && interlace <= 1;
}

// Walks through the chunks (the PNG specification, section 5). The decoder checks the sums of all but the header's.
std::optional<std::string> problem_of_png(std::string_view bytes) {
  constexpr size_t kSignature = 8, kHeader = 13, kAround = 12;  // length, name and sum of a chunk
  const Numbers number(bytes);
  if (bytes.size() < kSignature + kAround + kHeader) return too_short(bytes);
  if (number(kSignature, 4) != kHeader || bytes.substr(kSignature + 4, 4) != "IHDR" ||
      crc32(bytes.substr(kSignature + 4, 4 + kHeader)) != number(kSignature + 8 + kHeader, 4)) {
    return "the header of the image file is damaged";
  }
  if (!is_png_header(number(24, 1), number(25, 1), number(26, 1), number(27, 1), number(28, 1)))
    return "the header of the image file says what no PNG has";
  for (size_t at = kSignature; at + kAround <= bytes.size(); at += kAround + number(at, 4)) {
    if (number(at, 4) > bytes.size() - at - kAround) return too_short(bytes);
    if (bytes.substr(at + 4, 4) == "IEND") return problem_of_size(number(16, 4), number(20, 4));
  }
  return too_short(bytes);
}

// Walks through the headers, which may contain another complete JPEG (a preview), and looks for the end mark behind.
// Fill bytes and stray ones between segments are passed over, as the decoder does.
std::optional<std::string> problem_of_jpeg(std::string_view bytes) {
  const Numbers number(bytes);
  std::optional<std::string> size = "the image file has no size in its header";
  size_t at = 2;
  while (at + 4 <= bytes.size()) {
    const uint32_t marker = number(at + 1, 1);
    if (number(at, 1) != 0xff || marker == 0 || marker == 0xff) {
      ++at;
      continue;
    }
    if (marker == 0xda) break;
    const bool alone = marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7);  // it has no length
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) size = problem_of_size(number(at + 7, 2), number(at + 5, 2));
    at += alone ? 2 : 2 + number(at + 2, 2);
  }
  const size_t end = bytes.rfind("\xff\xd9");
  if (end == std::string_view::npos || end < at) return too_short(bytes);
  if (size) return size;
  if (!jpeg_scan_is_whole(bytes)) return "the compressed data of the image is damaged or cut short";
  return std::nullopt;
}

// TIFF 6.0, sections 3, 22 and the registered codes (libtiff's tiff.h): of others the decoder makes empty images.
bool is_tiff_coding(uint32_t bits, uint32_t compression) {
  constexpr std::array kBits = {1u, 4u, 8u, 10u, 12u, 14u, 16u, 32u, 64u};
  const bool known = compression <= 8 || (compression >= 32766 && compression <= 34934) || compression >= 50000;
  return known && compression > 0 && std::find(kBits.begin(), kBits.end(), bits) != kBits.end();
}

// Checks the size, and that all strips or tiles lie in the file (TIFF 6.0, section 2), for the first image.
std::optional<std::string> problem_of_tiff(std::string_view bytes) {
  const Numbers number(bytes, bytes[0] == 'I' ? Numbers::Order::little : Numbers::Order::big);
  const size_t list = number(4, 4), entries = number(list, 2);
  if (number(2, 2) != 42) return std::nullopt;  // BigTIFF
  if (list < 8 || list + 2 + 12 * entries > bytes.size()) return too_short(bytes);
  struct Array {
    size_t size = 0, count = 0, at = 0;  // bytes of an item
  };
  std::array<Array, 2> pieces;  // their places, and their lengths, which the decoder can do without
  uint32_t width = 0, height = 0, bits = 8, compression = 1;
  for (size_t e = list + 2; e < list + 2 + 12 * entries; e += 12) {
    const uint32_t tag = number(e, 2), type = number(e + 2, 2);
    const size_t size = type == 3 ? 2 : type == 4 ? 4 : 0, count = number(e + 4, 4);
    if (tag == 256) width = number(e + 8, size);
    if (tag == 257) height = number(e + 8, size);
    if (tag == 258 && count == 1) bits = number(e + 8, size);
    if (tag == 259) compression = number(e + 8, size);
    if (tag != 273 && tag != 324 && tag != 279 && tag != 325) continue;
    pieces[tag == 279 || tag == 325] = {size, count, size * count <= 4 ? e + 8 : number(e + 8, 4)};
  }
  if (const auto problem = problem_of_size(width, height)) return problem;
  if (!is_tiff_coding(bits, compression)) {
    return "its pixels have " + std::to_string(bits) + " bits and its compression is " + std::to_string(compression) +
           "; such a TIFF can't be read";
  }
  const auto& [places, lengths] = pieces;
  for (const Array& array : pieces) {
    if (array.at + array.size * array.count > bytes.size()) return too_short(bytes);
  }
  for (size_t k = 0; k < std::min(places.count, lengths.count); ++k) {
    const uint64_t place = number(places.at + k * places.size, places.size),
                   length = number(lengths.at + k * lengths.size, lengths.size);
    if (place + length > bytes.size()) return too_short(bytes);
  }
  return std::nullopt;
}

// Reads the words of a PBM, PGM or PPM header (netpbm.sourceforge.net/doc/pgm.html); comments go from # to a line's
// end.
class PnmWords {
 public:
  explicit PnmWords(std::string_view bytes) : bytes_(bytes) {}
  // Returns the next word; 0 where it is no positive number.
  uint32_t number() {
    while (at_ < bytes_.size() && (is_space(bytes_[at_]) || bytes_[at_] == '#')) {
      if (bytes_[at_] == '#') at_ = std::min(bytes_.find('\n', at_), bytes_.size() - 1);
      ++at_;
    }
    uint32_t value = 0;
    for (; at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9'; ++at_)
      value = std::min(10 * value + static_cast<uint32_t>(bytes_[at_] - '0'), kMost);
    return at_ < bytes_.size() && is_space(bytes_[at_]) ? value : 0;
  }
  // Returns the number of bytes behind the last word and the white space after it.
  size_t rest() const { return bytes_.size() - std::min(bytes_.size(), at_ + 1); }

 private:
  static constexpr uint32_t kMost = 100'000'000;
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  const std::string_view bytes_;
  size_t at_ = 2;
};

std::optional<std::string> problem_of_pnm(std::string_view bytes) {
  const char kind = bytes[1];
  PnmWords words(bytes);
  const uint32_t width = words.number(), height = words.number();
  const bool bitmap = kind == '1' || kind == '4';
  const uint32_t greatest = bitmap ? 1 : words.number();
  if (width == 0 || height == 0) return "the header of the image file has no size";
  if (const auto problem = problem_of_size(width, height)) return problem;
  if (greatest < 1 || greatest > 65535) return "the header of the image file has no greatest value from 1 to 65535";
  const bool in_words = kind < '4';
  const uint64_t row = kind == '4' ? (width + 7) / 8
                       : in_words  ? width
                                   : uint64_t{width} * (kind == '6' ? 3 : 1) * (greatest > 255 ? 2 : 1);
  if (words.rest() < row * height) return too_short(bytes);
  return std::nullopt;
}

// Checks that the rows of a BMP that is not compressed lie in the file (BITMAPINFOHEADER and its successors).
std::optional<std::string> problem_of_bmp(std::string_view bytes) {
  constexpr size_t kHeaders = 54;
  const Numbers number(bytes, Numbers::Order::little);
  if (bytes.size() < 26) return too_short(bytes);
  if (number(14, 4) < 40) return std::nullopt;  // OS/2 has another header
  if (bytes.size() < kHeaders) return too_short(bytes);
  const auto height = static_cast<int32_t>(number(22, 4));
  const uint64_t width = number(18, 4), rows = height < 0 ? -int64_t{height} : height;
  if (const auto problem = problem_of_size(static_cast<uint32_t>(width), static_cast<uint32_t>(rows))) return problem;
  const uint64_t row = (width * number(28, 2) + 31) / 32 * 4;
  if (number(30, 4) == 0 && number(10, 4) + row * rows > bytes.size()) return too_short(bytes);
  return std::nullopt;
}

}  // namespace

std::optional<std::string> problem_of_image(std::string_view bytes) {
  if (bytes.empty()) return "the image file is empty";
  if (bytes.starts_with("\x89PNG")) return problem_of_png(bytes);
  if (bytes.starts_with("\xff\xd8")) return problem_of_jpeg(bytes);
  if (bytes.starts_with("II*") || bytes.starts_with("MM")) return problem_of_tiff(bytes);
  if (bytes.starts_with("BM")) return problem_of_bmp(bytes);
  if (bytes.size() >= 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return problem_of_pnm(bytes);
  return std::nullopt;
}

}  // namespace covis::io
