// SPDX-License-Identifier: Apache-2.0
// Compressed images, by OpenCV's imgcodecs, which brings GDAL and a hundred other libraries: it is in a plug-in, so its
// functions are not linked. For .cpp files that have images of OpenCV.
#pragma once

#include <cstdint>
#include <opencv2/imgcodecs.hpp>  // for its flags
#include <string>
#include <vector>

#include "covis/core/error.h"

namespace covis::io {

// Returns the bytes of an image file. ending: ".png", ".jpg"; parameters: those of cv::imencode.
Result<std::string> encode_image(const std::string& ending, const cv::Mat& image,
                                 const std::vector<int>& parameters = {});

// plugin_codecs.cpp
struct CodecPlugin {
  static constexpr const char *kName = "covis_codecs", *kPurpose = "reads and writes compressed images";
  // cv::imdecode and cv::imencode.
  void (*decode)(const cv::Mat& bytes, int flags, cv::Mat& image);
  bool (*encode)(const std::string& ending, const cv::Mat& image, const std::vector<int>& parameters,
                 std::vector<uint8_t>& bytes);
};

}  // namespace covis::io
