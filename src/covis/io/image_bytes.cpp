// SPDX-License-Identifier: Apache-2.0
#include "covis/io/image_bytes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <utility>

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

constexpr const char* kNoImage = "it is not an image that can be read (PNG, JPEG, TIFF, BMP, PBM, PGM, PPM, WebP)";

std::string too_short(std::string_view bytes) {
  return "the image file is cut short (" + std::to_string(bytes.size()) + " bytes)";
}

bool holds(std::string_view bytes, size_t at, std::string_view text) {
  return bytes.size() >= at + text.size() && bytes.substr(at, text.size()) == text;
}

std::optional<std::string> problem_of_size(int64_t width, int64_t height, const ExpectedSize& expected) {
  constexpr int64_t kMost = kLargestImageSide;
  if (width < 1 || height < 1 || width > kMost || height > kMost || width * height > kMostImagePixels) {
    return "its header says that the image is " + std::to_string(width) + "x" + std::to_string(height) +
           "; sides of 1 to " + std::to_string(kMost) + " pixels and " + std::to_string(kMostImagePixels / 1'000'000) +
           " million pixels in all can be read";
  }
  const bool upright = width == expected.width && height == expected.height,
             turned = width == expected.height && height == expected.width;
  if (expected.width == 0 || upright || turned) return std::nullopt;
  return wrong_size(width, height, expected);
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

// Bytes of a PNG: its signature, the header's data, and length, name and sum of a chunk.
constexpr size_t kSignature = 8, kHeader = 13, kAround = 12;

// Walks through the chunks (the PNG specification, section 5). The decoder checks the sums of all but the header's.
std::optional<std::string> problem_of_png(std::string_view bytes, const ExpectedSize& expected) {
  const Numbers number(bytes);
  if (bytes.size() < kSignature + kAround + kHeader) return too_short(bytes);
  if (!holds(bytes, 4, "\r\n\x1a\n") || number(kSignature, 4) != kHeader || bytes.substr(kSignature + 4, 4) != "IHDR" ||
      crc32(bytes.substr(kSignature + 4, 4 + kHeader)) != number(kSignature + 8 + kHeader, 4)) {
    return "the header of the image file is damaged";
  }
  if (!is_png_header(number(24, 1), number(25, 1), number(26, 1), number(27, 1), number(28, 1)))
    return "the header of the image file says what no PNG has";
  for (size_t at = kSignature; at + kAround <= bytes.size(); at += kAround + number(at, 4)) {
    if (number(at, 4) > bytes.size() - at - kAround) return too_short(bytes);
    if (bytes.substr(at + 4, 4) == "IEND") return problem_of_size(number(16, 4), number(20, 4), expected);
  }
  return too_short(bytes);
}

// A progressive JPEG of three colours usually has ten scans; each is decoded over the whole image. What is behind the
// end mark may be anything, such as raw data or a video.
bool has_too_many_scans(std::string_view bytes, size_t at) {
  constexpr int kMostScans = 100;
  const Numbers number(bytes);
  int scans = 0;
  while (scans <= kMostScans && (at = bytes.find('\xff', at)) != std::string_view::npos) {
    const uint32_t marker = number(at + 1, 1);
    if (marker == 0xd9) break;
    scans += marker == 0xda;
    const bool alone = marker < 0xc0 || (marker >= 0xd0 && marker <= 0xd8);  // it has no length, or the decoder stops
    at += marker == 0xff ? 1 : alone ? 2 : 2 + number(at + 2, 2);
  }
  return scans > kMostScans;
}

// Walks through the headers, which may contain another complete JPEG (a preview), and looks for the end mark behind.
// Fill bytes and stray ones between segments are passed over, as the decoder does.
std::optional<std::string> problem_of_jpeg(std::string_view bytes, const ExpectedSize& expected) {
  const Numbers number(bytes);
  if (bytes.size() > 2 && number(2, 1) != 0xff) return "the header of the image file is damaged";
  std::optional<std::string> size = "the image file has no size in its header";
  int frames = 0;
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
    if (frame && ++frames > 1) return "the header of the image file gives its size twice; a JPEG has one";
    if (frame) size = problem_of_size(number(at + 7, 2), number(at + 5, 2), expected);
    at += alone ? 2 : 2 + number(at + 2, 2);
  }
  const size_t end = bytes.rfind("\xff\xd9");
  if (end == std::string_view::npos || end < at) return too_short(bytes);
  if (size) return size;
  if (has_too_many_scans(bytes, at)) return "the image is given in more scans than any real JPEG has";
  if (!jpeg_scan_is_whole(bytes) || !progressive_jpeg_is_whole(bytes))
    return "the compressed data of the image is damaged or cut short";
  return std::nullopt;
}

// TIFF 6.0, sections 3, 9 and 13, and deflate (registered as 8 and 32946). Others of libtiff's codes are for fax pages,
// hold an image of another format, or come out empty.
bool is_tiff_coding(uint32_t bits, uint32_t compression) {
  constexpr std::array kBits = {1u, 4u, 8u, 10u, 12u, 14u, 16u, 32u, 64u};
  constexpr std::array kCompressions = {1u, 5u, 8u, 32773u, 32946u};
  return std::find(kBits.begin(), kBits.end(), bits) != kBits.end() &&
         std::find(kCompressions.begin(), kCompressions.end(), compression) != kCompressions.end();
}

// The first image of a TIFF (TIFF 6.0, sections 2, 8 and 15).
struct Tiff {
  struct Array {
    size_t size = 0, count = 0, at = 0;  // bytes of an item
  };
  Array places, lengths;  // by strip or tile; the decoder can do without the lengths
  uint32_t width = 0, height = 0, bits = 8, samples = 1, compression = 1, colours = 1, planes = 1, fill = 1;
  uint32_t tile_width = 0, tile_height = 0;  // 0: it has strips
  uint32_t strip_height = ~0u;
};

// Reads the directory from its first entry on.
Tiff read_tiff(const Numbers& number, size_t from, size_t entries) {
  Tiff tiff;
  std::set<uint32_t> seen;
  for (size_t e = from; e < from + 12 * entries; e += 12) {
    const uint32_t tag = number(e, 2), type = number(e + 2, 2);
    const size_t size = type == 3 ? 2 : type == 4 ? 4 : 0, count = number(e + 4, 4);
    if (!seen.insert(tag).second) continue;  // the decoder takes the first as well
    const size_t at = size * count <= 4 ? e + 8 : number(e + 8, 4);
    const std::pair<uint32_t, uint32_t*> values[] = {
        {256, &tiff.width},   {257, &tiff.height},     {258, &tiff.bits},       {259, &tiff.compression},
        {262, &tiff.colours}, {266, &tiff.fill},       {277, &tiff.samples},    {278, &tiff.strip_height},
        {284, &tiff.planes},  {322, &tiff.tile_width}, {323, &tiff.tile_height}};
    for (const auto& [known, value] : values) {
      if (tag == known) *value = number(at, size);
    }
    if (tag == 273 || tag == 324) tiff.places = {size, count, at};
    if (tag == 279 || tag == 325) tiff.lengths = {size, count, at};
  }
  return tiff;
}

// Checks that all strips or tiles lie in the file and unpack to their rows, which are those that a decoder fills.
std::optional<std::string> problem_of_pieces(std::string_view bytes, const Numbers& number, const Tiff& tiff) {
  const Tiff::Array &places = tiff.places, &lengths = tiff.lengths;
  for (const Tiff::Array& array : {places, lengths}) {
    if (array.at + array.size * array.count > bytes.size()) return too_short(bytes);
  }
  const bool tiled = tiff.tile_width > 0 && tiff.tile_height > 0;
  const uint64_t width = tiled ? tiff.tile_width : tiff.width,
                 height = std::max(1u, tiled ? tiff.tile_height : std::min(tiff.strip_height, tiff.height)),
                 row = (width * tiff.bits * (tiff.planes == 2 ? 1 : tiff.samples) + 7) / 8,
                 in_plane = (tiff.height + height - 1) / height * (tiled ? (tiff.width + width - 1) / width : 1),
                 pieces = std::min<uint64_t>(in_plane * (tiff.planes == 2 ? tiff.samples : 1), bytes.size());
  constexpr uint32_t kYCbCr = 6;  // some of its rows are left out
  const bool looked_at = tiff.colours != kYCbCr && tiff.fill == 1;
  uint64_t all = 0;  // bytes of the pieces, which may share some by mistake or malice
  // The decoder asks for no more pieces than the image has; a list of a type without a size may name any number.
  for (size_t k = 0; k < std::min({places.count, lengths.count, pieces}); ++k) {
    const uint64_t place = number(places.at + k * places.size, places.size),
                   length = number(lengths.at + k * lengths.size, lengths.size);
    if (place + length > bytes.size()) return too_short(bytes);
    all += length;
    if (all > bytes.size()) return "its strips or tiles overlap: together they are longer than the file";
    const uint64_t rows = tiled ? height : std::min(height, tiff.height - k % in_plane * height);
    if (looked_at && !tiff_piece_is_whole(tiff.compression, bytes.substr(place, length), row * rows))
      return "the compressed data of the image is damaged or cut short";
  }
  return std::nullopt;
}

std::optional<std::string> problem_of_tiff(std::string_view bytes, const ExpectedSize& expected) {
  const Numbers number(bytes, bytes[0] == 'I' ? Numbers::Order::little : Numbers::Order::big);
  const size_t list = number(4, 4), entries = number(list, 2);
  if (number(2, 2) == 43) return "it is a BigTIFF, which is not read here; a TIFF can be";
  if (number(2, 2) != 42) return kNoImage;
  if (list < 8 || list + 2 + 12 * entries > bytes.size()) return too_short(bytes);
  const Tiff tiff = read_tiff(number, list + 2, entries);
  if (const auto problem = problem_of_size(tiff.width, tiff.height, expected)) return problem;
  if (const auto problem = problem_of_size(std::max(1u, tiff.tile_width), std::max(1u, tiff.tile_height), {}))
    return problem;
  if (!is_tiff_coding(tiff.bits, tiff.compression)) {
    return "its pixels have " + std::to_string(tiff.bits) + " bits and its compression is " +
           std::to_string(tiff.compression) + "; such a TIFF can't be read";
  }
  return problem_of_pieces(bytes, number, tiff);
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
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  // Returns the number of bytes behind the last word and the white space after it.
  size_t rest() const { return bytes_.size() - std::min(bytes_.size(), at_ + 1); }

 private:
  static constexpr uint32_t kMost = 100'000'000;

  const std::string_view bytes_;
  size_t at_ = 2;
};

std::optional<std::string> problem_of_pnm(std::string_view bytes, const ExpectedSize& expected) {
  if (bytes.size() > 2 && !PnmWords::is_space(bytes[2])) return kNoImage;
  const char kind = bytes[1];
  PnmWords words(bytes);
  const uint32_t width = words.number(), height = words.number();
  const bool bitmap = kind == '1' || kind == '4';
  const uint32_t greatest = bitmap ? 1 : words.number();
  if (width == 0 || height == 0) return "the header of the image file has no size";
  if (const auto problem = problem_of_size(width, height, expected)) return problem;
  if (greatest < 1 || greatest > 65535) return "the header of the image file has no greatest value from 1 to 65535";
  const bool in_words = kind < '4';
  const uint64_t row = kind == '4' ? (width + 7) / 8
                       : in_words  ? width
                                   : uint64_t{width} * (kind == '6' ? 3 : 1) * (greatest > 255 ? 2 : 1);
  if (words.rest() < row * height) return too_short(bytes);
  return std::nullopt;
}

// Checks that the rows of a BMP that is not compressed lie in the file (BITMAPINFOHEADER and its successors).
std::optional<std::string> problem_of_bmp(std::string_view bytes, const ExpectedSize& expected) {
  constexpr size_t kHeaders = 54;
  const Numbers number(bytes, Numbers::Order::little);
  if (bytes.size() < 26) return too_short(bytes);
  if (number(14, 4) < 40)
    return "it is a BMP of OS/2 or a damaged one; one with a header of 40 bytes or more can be read";
  if (bytes.size() < kHeaders) return too_short(bytes);
  const auto height = static_cast<int32_t>(number(22, 4));
  const int64_t width = number(18, 4), rows = height < 0 ? -int64_t{height} : height;
  if (const auto problem = problem_of_size(width, rows, expected)) return problem;
  const uint32_t compression = number(30, 4);
  if (compression != 0 && compression != 3)  // 3: not compressed, with masks of the colours' bits
    return "its compression is " + std::to_string(compression) + "; such a BMP can't be read";
  const int64_t row = (width * number(28, 2) + 31) / 32 * 4;
  if (number(10, 4) + row * rows > static_cast<int64_t>(bytes.size())) return too_short(bytes);
  return std::nullopt;
}

// Checks the size of a still image (RFC 9649, sections 2 and 3); the decoder tells when data are missing.
std::optional<std::string> problem_of_webp(std::string_view bytes, const ExpectedSize& expected) {
  constexpr size_t kHeaders = 32;  // the decoder wants so many
  const Numbers number(bytes, Numbers::Order::little);
  if (bytes.size() < kHeaders || number(4, 4) > bytes.size() - 8) return too_short(bytes);
  if (holds(bytes, 12, "VP8 ") && holds(bytes, 23, "\x9d\x01\x2a"))
    return problem_of_size(number(26, 2) & 0x3fff, number(28, 2) & 0x3fff, expected);
  if (holds(bytes, 12, "VP8L") && holds(bytes, 20, "\x2f")) {
    const uint32_t sides = number(21, 4);  // two of 14 bits, less 1
    return problem_of_size((sides & 0x3fff) + 1, (sides >> 14 & 0x3fff) + 1, expected);
  }
  constexpr uint32_t kAnimated = 2;
  if (holds(bytes, 12, "VP8X") && (number(20, 1) & kAnimated) == 0)
    return problem_of_size(number(24, 3) + 1, number(27, 3) + 1, expected);
  return "the header of the image file is damaged, or that of an animation";
}

}  // namespace

std::string wrong_size(int64_t width, int64_t height, const ExpectedSize& expected) {
  return "the image is " + std::to_string(width) + "x" + std::to_string(height) + ", the camera of " + expected.camera +
         " is " + std::to_string(expected.width) + "x" + std::to_string(expected.height);
}

// OpenCV gives bytes to the first decoder that knows their beginning. Those of DICOM and of GDAL, which opens whatever
// files and addresses the bytes name, look for "DICM" and "DTED" behind it, and come after those for what passes here.
// Such bytes are refused all the same, for a WebP may be one that its decoder does not know.
std::optional<std::string> problem_of_image(std::string_view bytes, const ExpectedSize& expected) {
  if (bytes.empty()) return "the image file is empty";
  if (holds(bytes, 128, "DICM") || holds(bytes, 140, "DTED")) return kNoImage;
  if (bytes.starts_with("\x89PNG")) return problem_of_png(bytes, expected);
  if (bytes.starts_with("\xff\xd8")) return problem_of_jpeg(bytes, expected);
  if (bytes.starts_with("II") || bytes.starts_with("MM")) return problem_of_tiff(bytes, expected);
  if (bytes.starts_with("BM")) return problem_of_bmp(bytes, expected);
  if (bytes.size() >= 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6')
    return problem_of_pnm(bytes, expected);
  if (bytes.starts_with("RIFF") && holds(bytes, 8, "WEBP")) return problem_of_webp(bytes, expected);
  return kNoImage;
}

std::string without_texts(std::string_view bytes) {
  std::string kept;
  if (!bytes.starts_with("\x89PNG")) return kept;
  const Numbers number(bytes);
  size_t copied = 0;  // bytes that are in `kept` or left out
  for (size_t at = kSignature; at + kAround <= bytes.size() && !holds(bytes, at + 4, "IEND");) {
    const size_t next = at + kAround + number(at, 4);
    if (holds(bytes, at + 4, "zTXt") || holds(bytes, at + 4, "iTXt")) {
      kept += bytes.substr(copied, at - copied);
      copied = next;
    }
    at = next;
  }
  if (copied > 0) kept += bytes.substr(copied);
  return kept;
}

}  // namespace covis::io
