// SPDX-License-Identifier: Apache-2.0
// Between OpenCV's images and ours. For .cpp files only.
#pragma once

#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "covis/io/images.h"

namespace covis::io {

// Returns the image's memory as a matrix of the type.
template <class T>
cv::Mat as_mat(Image<T>& image, int type) {
  if (image.empty()) return {};
  return {image.height(), image.width(), type, image.row(0), static_cast<size_t>(image.stride()) * sizeof(T)};
}

// Decodes the bytes of an image file with cv::imdecode's flags, into `to`'s memory if size and type match, else into
// new memory. name: for messages.
Result<cv::Mat> decode_image(const std::string& name, std::string_view bytes, int flags, cv::Mat to,
                             const ExpectedSize& expected = {});

// Converts a depth image of 16 bits, divided by `scale` (units per metre), or of 32-bit float, in metres. Negative and
// non-finite depths, and 65535 of 16 bits, become 0 (no measurement). Bytes in `stored` must be aligned for its type.
void depth_in_metres(const cv::Mat& stored, double scale, ImageF& depth);

// OpenCV's flags to decode an image that in_eight_bits() is to be made of: those for 8 bits, unless `bits` asks for
// all 16.
inline int with_depth(int flags, int bits) { return bits < 16 ? flags | cv::IMREAD_ANYDEPTH : flags; }

// Returns an image of 8 bits: itself, or one of 16 bits of which `bits` are used.
inline cv::Mat in_eight_bits(const cv::Mat& image, int bits) {
  if (image.depth() == CV_8U) return image;
  cv::Mat eight;
  image.convertTo(eight, CV_8U, 1.0 / (1 << (bits - 8)));
  return eight;
}

// Blue is first in OpenCV's.
inline Picture picture_of(const cv::Mat& image) {
  Picture picture{.width = image.cols, .height = image.rows, .channels = image.channels() == 1 ? 1 : 3, .bytes = {}};
  picture.bytes.resize(picture.row_bytes() * static_cast<size_t>(image.rows));
  cv::Mat rgb = image;
  if (image.channels() > 1) cv::cvtColor(image, rgb, image.channels() == 4 ? cv::COLOR_BGRA2RGB : cv::COLOR_BGR2RGB);
  for (int y = 0; y < image.rows; ++y) std::memcpy(picture.row(y), rgb.ptr(y), picture.row_bytes());
  return picture;
}

// The same the other way, in memory of its own where there are colours.
inline cv::Mat mat_of(const Picture& picture) {
  const cv::Mat image(picture.height, picture.width, picture.coloured() ? CV_8UC3 : CV_8UC1,
                      const_cast<uint8_t*>(picture.bytes.data()));
  if (!picture.coloured()) return image;
  cv::Mat blue_first;
  cv::cvtColor(image, blue_first, cv::COLOR_RGB2BGR);
  return blue_first;
}

// Converts a decoded image, grey or with blue first, to grey in `grey`'s memory.
inline void to_grey(const cv::Mat& image, ImageU8& grey) {
  grey.resize(image.cols, image.rows);
  cv::Mat to = as_mat(grey, CV_8UC1);
  if (image.channels() == 1) {
    image.copyTo(to);
  } else {
    cv::cvtColor(image, to, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
  }
}

}  // namespace covis::io
