// SPDX-License-Identifier: Apache-2.0
// The structure of image files, looked at before their pixels are decoded: decoders fill what is missing with grey,
// keep to themselves that data was damaged, and ask for memory of whatever size a header claims.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace covis::io {

inline constexpr int kLargestImageSide = 20000;  // pixels

// Says what is wrong with the bytes of an image file: cut short, a damaged header, an absurd size, or (JPEG other than
// progressive) compressed data that ends early or does not fit. nullopt where nothing is, and for other formats than
// PNG, JPEG and TIFF.
std::optional<std::string> problem_of_image(std::string_view bytes);

// The same of the compressed data of a JPEG file that has sequential Huffman coding, by walking through its codes as a
// decoder does (ITU T.81, sections F.2.2 and E.2). True also for what is coded in another way: it is not looked at.
bool jpeg_scan_is_whole(std::string_view bytes);

}  // namespace covis::io
