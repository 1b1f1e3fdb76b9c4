// SPDX-License-Identifier: Apache-2.0
// Pixels of image messages.
#pragma once

#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/io/images.h"
#include "covis/io/ros_message.h"

namespace covis::io {

// Decodes into reused memory. Errors name the field of the message. Not thread-safe.
class RosImageDecoder {
 public:
  // From now on compressed images of another size are refused before they are decoded.
  void expect(const ExpectedSize& size) { expected_ = size; }
  void use_bits(int bits) { bits_ = bits; }  // see ImageSource
  // The upper 8 of those of 16 bits that are used are kept.
  Result<void> grey(const RosImage& message, ImageU8& image);
  Result<void> grey(const RosCompressedImage& message, ImageU8& image);
  // Reads depth in metres: 16UC1 in units of 1 / scale metres, 32FC1 in metres. Negative and non-finite depths, and
  // 65535 of 16 bits, become 0 (no measurement).
  Result<void> depth(const RosImage& message, double scale, ImageF& depth);
  Result<void> depth(const RosCompressedImage& message, double scale, ImageF& depth);
  Result<Picture> picture(const RosImage& message);
  Result<Picture> picture(const RosCompressedImage& message);

 private:
  ExpectedSize expected_;
  int bits_ = 16;
  Image<uint16_t> words_;
  ImageF floats_;
};

// False when the message says that it is grey.
bool may_have_colours(const RosImage& message);
bool may_have_colours(const RosCompressedImage& message);

}  // namespace covis::io
