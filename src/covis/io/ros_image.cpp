// SPDX-License-Identifier: Apache-2.0
#include "covis/io/ros_image.h"

#include <algorithm>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "covis/io/opencv_picture.h"

namespace covis::io {
namespace {

constexpr uint32_t kLargestSide = 32767;  // pixels
constexpr int kCopy = -1;                 // no conversion is needed
constexpr int kUpperBits = -2;            // the upper 8 of those that are used

// How pixels of an encoding are stored, and OpenCV's conversions of them.
struct Encoding {
  const char* name;
  int type;       // OpenCV's
  int to_grey;    // or kCopy, kUpperBits
  int to_colour;  // to blue, green and red; kCopy: they are stored so; unused when grey
  bool coloured;
};

// OpenCV names a Bayer pattern by its second row, ROS by its first.
constexpr Encoding kEncodings[] = {
    {"mono8", CV_8UC1, kCopy, 0, false},
    {"8UC1", CV_8UC1, kCopy, 0, false},
    {"mono16", CV_16UC1, kUpperBits, 0, false},
    {"16UC1", CV_16UC1, kUpperBits, 0, false},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR, true},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY, kCopy, true},
    {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY, kCopy, true},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR, true},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR, true},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR, true},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR, true},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR, true},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR, true},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR, true},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, cv::COLOR_YUV2BGR_UYVY, true},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2, cv::COLOR_YUV2BGR_YUY2, true},
};
constexpr Encoding kDepthEncodings[] = {
    {"16UC1", CV_16UC1, 0, 0, false}, {"mono16", CV_16UC1, 0, 0, false}, {"32FC1", CV_32FC1, 0, 0, false}};

template <size_t kCount>
Result<const Encoding*> find_encoding(const Encoding (&known)[kCount], std::string_view name) {
  std::string names;
  for (const Encoding& encoding : known) {
    if (name == encoding.name) return &encoding;
    names += (names.empty() ? "" : ", ") + std::string(encoding.name);
  }
  return fail("encoding '" + std::string(name.substr(0, 40)) + "' can't be used; it must be one of " + names);
}

// Checks that the data holds all rows.
Result<void> check_data(const RosImage& m, int type) {
  if (m.width < 1 || m.height < 1 || m.width > kLargestSide || m.height > kLargestSide) {
    return fail("an image of " + std::to_string(m.width) + "x" + std::to_string(m.height) +
                " pixels can't be read; sides must be 1 to " + std::to_string(kLargestSide));
  }
  const size_t row = m.width * static_cast<size_t>(CV_ELEM_SIZE(type));
  if (m.step < row) {
    return fail("step is " + std::to_string(m.step) + ", a row of " + std::to_string(m.width) + " pixels of " +
                std::string(m.encoding) + " takes " + std::to_string(row) + " bytes");
  }
  const size_t needed = static_cast<size_t>(m.step) * (m.height - 1) + row;
  if (m.data.size() < needed)
    return fail("data has " + std::to_string(m.data.size()) + " bytes, the image takes " + std::to_string(needed));
  return {};
}

// Copies pixels of several bytes to where they are aligned, in this machine's order of bytes.
template <class T>
void copy_pixels(const RosImage& m, Image<T>& to) {
  to.resize(static_cast<int>(m.width), static_cast<int>(m.height));
  for (int y = 0; y < to.height(); ++y) {
    auto* out = reinterpret_cast<char*>(to.row(y));
    std::memcpy(out, m.data.data() + static_cast<size_t>(y) * m.step, m.width * sizeof(T));
    if (!m.big_endian) continue;
    for (uint32_t x = 0; x < m.width; ++x) std::reverse(out + x * sizeof(T), out + (x + 1) * sizeof(T));
  }
}

// The message's own bytes as a matrix.
cv::Mat pixels_of(const RosImage& m, int type) {
  return {static_cast<int>(m.height), static_cast<int>(m.width), type, const_cast<char*>(m.data.data()), m.step};
}

// A compressed depth image: a header of three 32-bit values (format, and two parameters of inverse depth), then a PNG.
struct CompressedDepth {
  bool inverse = false;  // the PNG holds a / depth + b, else 16-bit depth
  float a = 0, b = 0;
  std::string_view png;
};

Result<CompressedDepth> compressed_depth(const RosCompressedImage& m) {
  constexpr size_t kHeader = 12;
  if (m.format.find("compressedDepth") == std::string_view::npos || m.format.find("rvl") != std::string_view::npos) {
    return fail("format '" + std::string(m.format.substr(0, 60)) +
                "' can't be used for depth; it must be 'compressedDepth' with PNG");
  }
  if (m.data.size() <= kHeader) return fail("data has " + std::to_string(m.data.size()) + " bytes, which is no image");
  CompressedDepth depth;
  depth.inverse = m.format.starts_with("32FC1");
  std::memcpy(&depth.a, m.data.data() + 4, sizeof depth.a);
  std::memcpy(&depth.b, m.data.data() + 8, sizeof depth.b);
  depth.png = m.data.substr(kHeader);
  return depth;
}

// The pattern of a Bayer camera whose images are compressed as they were taken ("bayer_rggb16; png compressed "), one
// value a pixel, as that of 8 bits; empty: it is none, or they were made colours ("bayer_rggb8; png compressed bgr8").
std::string bayer_encoding(const RosCompressedImage& m) {
  std::string encoding(m.format.substr(0, m.format.find(';')));
  const std::string_view last = m.format.substr(m.format.find_last_of(' ') + 1);
  if (!encoding.starts_with("bayer_") || last == "bgr8" || last == "rgb8") return "";
  if (encoding.ends_with("16")) encoding.replace(encoding.size() - 2, 2, "8");
  return encoding;
}

Result<cv::Mat> decode_compressed(const RosCompressedImage& m, int flags, cv::Mat to, const ExpectedSize& expected) {
  if (m.format.find("compressedDepth") != std::string_view::npos)
    return fail("format '" + std::string(m.format.substr(0, 60)) + "' is that of a depth image");
  return decode_image("data", m.data, flags, std::move(to), expected);
}

// A message that holds these grey values.
RosImage message_of(const cv::Mat& grey, std::string_view encoding) {
  return {.header = {},
          .width = static_cast<uint32_t>(grey.cols),
          .height = static_cast<uint32_t>(grey.rows),
          .encoding = encoding,
          .step = static_cast<uint32_t>(grey.step[0]),
          .data = {grey.ptr<char>(), grey.step[0] * static_cast<size_t>(grey.rows)}};
}

}  // namespace

Result<void> RosImageDecoder::grey(const RosImage& message, ImageU8& image) {
  const auto found = find_encoding(kEncodings, message.encoding);
  if (!found) return tl::unexpected(found.error());
  const Encoding& encoding = **found;
  if (auto checked = check_data(message, encoding.type); !checked) return checked;
  image.resize(static_cast<int>(message.width), static_cast<int>(message.height));
  if (encoding.to_grey == kUpperBits) {
    copy_pixels(message, words_);
    const int shift = bits_ - 8;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) image(x, y) = static_cast<uint8_t>(std::min(words_(x, y) >> shift, 255));
    }
    return {};
  }
  cv::Mat grey = as_mat(image, CV_8UC1);
  try {
    if (encoding.to_grey == kCopy) {
      pixels_of(message, encoding.type).copyTo(grey);
    } else {
      cv::cvtColor(pixels_of(message, encoding.type), grey, encoding.to_grey);
    }
  } catch (const cv::Exception&) {  // Bayer and YUV images must have even or more than two columns
    return fail("an image of " + std::to_string(message.width) + "x" + std::to_string(message.height) +
                " pixels can't be converted from " + encoding.name);
  }
  return {};
}

Result<void> RosImageDecoder::grey(const RosCompressedImage& message, ImageU8& image) {
  if (const std::string bayer = bayer_encoding(message); !bayer.empty()) {
    const auto stored = decode_compressed(message, with_depth(cv::IMREAD_ANYCOLOR, bits_), {}, expected_);
    if (!stored) return tl::unexpected(stored.error());
    if (stored->channels() == 1) return grey(message_of(in_eight_bits(*stored, bits_), bayer), image);
  }
  const auto decoded =
      decode_compressed(message, with_depth(cv::IMREAD_GRAYSCALE, bits_), as_mat(image, CV_8UC1), expected_);
  if (!decoded) return tl::unexpected(decoded.error());
  if (!image.empty() && decoded->data == image.row(0)) return {};
  image.resize(decoded->cols, decoded->rows);
  in_eight_bits(*decoded, bits_).copyTo(as_mat(image, CV_8UC1));
  return {};
}

Result<void> RosImageDecoder::depth(const RosImage& message, double scale, ImageF& depth) {
  const auto encoding = find_encoding(kDepthEncodings, message.encoding);
  if (!encoding) return tl::unexpected(encoding.error());
  const int type = (*encoding)->type;
  if (auto checked = check_data(message, type); !checked) return checked;
  if (type == CV_16UC1) {
    copy_pixels(message, words_);
    depth_in_metres(as_mat(words_, type), scale, depth);
  } else {
    copy_pixels(message, floats_);
    depth_in_metres(as_mat(floats_, type), 1, depth);
  }
  return {};
}

Result<void> RosImageDecoder::depth(const RosCompressedImage& message, double scale, ImageF& depth) {
  const auto compressed = compressed_depth(message);
  if (!compressed) return tl::unexpected(compressed.error());
  const auto decoded = decode_image("data", compressed->png, cv::IMREAD_UNCHANGED, {}, expected_);
  if (!decoded) return tl::unexpected(decoded.error());
  if (decoded->type() != CV_16UC1) return fail("data: a compressed depth image must have one channel of 16 bits");
  depth_in_metres(*decoded, compressed->inverse ? 1 : scale, depth);
  if (!compressed->inverse) return {};
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const float stored = depth(x, y), metres = compressed->a / (stored - compressed->b);
      depth(x, y) = stored > 0 && std::isfinite(metres) && metres > 0 ? metres : 0;
    }
  }
  return {};
}

Result<Picture> RosImageDecoder::picture(const RosImage& message) {
  const auto found = find_encoding(kEncodings, message.encoding);
  if (!found) return tl::unexpected(found.error());
  const Encoding& encoding = **found;
  if (!encoding.coloured) {
    ImageU8 image;
    if (auto read = grey(message, image); !read) return tl::unexpected(read.error());
    return picture_of(as_mat(image, CV_8UC1));
  }
  if (auto checked = check_data(message, encoding.type); !checked) return tl::unexpected(checked.error());
  cv::Mat colours = pixels_of(message, encoding.type);
  try {
    if (encoding.to_colour != kCopy) {
      cv::Mat converted;
      cv::cvtColor(colours, converted, encoding.to_colour);
      colours = converted;
    }
  } catch (const cv::Exception&) {
    return fail("an image of " + std::to_string(message.width) + "x" + std::to_string(message.height) +
                " pixels can't be converted from " + encoding.name);
  }
  return picture_of(colours);
}

Result<Picture> RosImageDecoder::picture(const RosCompressedImage& message) {
  const auto decoded = decode_compressed(message, with_depth(cv::IMREAD_ANYCOLOR, bits_), {}, expected_);
  if (!decoded) return tl::unexpected(decoded.error());
  const cv::Mat pixels = in_eight_bits(*decoded, bits_);
  const std::string bayer = bayer_encoding(message);
  return bayer.empty() || pixels.channels() != 1 ? picture_of(pixels) : picture(message_of(pixels, bayer));
}

bool may_have_colours(const RosImage& message) {
  const auto encoding = find_encoding(kEncodings, message.encoding);
  return encoding && (*encoding)->coloured;
}

bool may_have_colours(const RosCompressedImage& message) { return !message.format.starts_with("mono"); }

}  // namespace covis::io
