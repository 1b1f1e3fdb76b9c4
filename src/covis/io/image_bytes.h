// SPDX-License-Identifier: Apache-2.0
// The structure of image files, looked at before their pixels are decoded: decoders fill what is missing with grey,
// keep to themselves that data was damaged, and ask for memory of whatever size a header claims.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace covis::io {

inline constexpr int kLargestImageSide = 20000;           // pixels
inline constexpr int64_t kMostImagePixels = 100'000'000;  // larger images are not decoded

// The size that images must have, before or after they are turned as their EXIF orientation says.
struct ExpectedSize {
  int width = 0, height = 0;  // pixels; 0: any size
  std::string camera;         // the source of the size, for messages
};
// Says that an image has another size than it should.
std::string wrong_size(int64_t width, int64_t height, const ExpectedSize& expected);

// Says why an image file must not be handed to a decoder: its format is none of PNG, JPEG, TIFF, BMP, PBM, PGM, PPM and
// WebP, or OpenCV would not choose that format's decoder; it is cut short; its header is damaged, or tells an absurd
// size or another one than expected; compressed data of a JPEG or TIFF end early or do not fit.
// nullopt where nothing is wrong.
std::optional<std::string> problem_of_image(std::string_view bytes, const ExpectedSize& expected = {});

// Returns a PNG without the compressed texts in it, which nobody reads and a decoder would unpack; empty where it has
// none, or is another format. The bytes have no problem.
std::string without_texts(std::string_view bytes);

// The same of the compressed data of a JPEG file that has sequential Huffman coding, by walking through its codes as a
// decoder does (ITU T.81, sections F.2.2 and E.2). True also for what is coded in another way: it is not looked at.
bool jpeg_scan_is_whole(std::string_view bytes);
// The same of all scans of a JPEG file that is progressive and has Huffman coding.
bool progressive_jpeg_is_whole(std::string_view bytes);

// True when the data of a strip or tile of a TIFF unpack to as many bytes at least. compression: 1 (none), 5 (LZW), 8
// or 32946 (deflate), 32773 (PackBits). True also for LZW of before TIFF 5.0: it is not looked at.
bool tiff_piece_is_whole(uint32_t compression, std::string_view data, size_t expected);

}  // namespace covis::io
