// SPDX-License-Identifier: Apache-2.0
// The plug-in covis_codecs: compressed images.
#include "covis/io/codecs.h"
#include "covis/io/plugin.h"

namespace covis::io {
namespace {

void decode(const cv::Mat& bytes, int flags, cv::Mat& image) { cv::imdecode(bytes, flags, &image); }

bool encode(const std::string& ending, const cv::Mat& image, const std::vector<int>& parameters,
            std::vector<uint8_t>& bytes) {
  return cv::imencode(ending, image, bytes, parameters);
}

}  // namespace
COVIS_PLUGIN(CodecPlugin, decode, encode)

}  // namespace covis::io
