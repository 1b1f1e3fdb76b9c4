// SPDX-License-Identifier: Apache-2.0
#include "covis/io/codecs.h"

#include "covis/io/plugin.h"

namespace covis::io {

Result<std::string> encode_image(const std::string& ending, const cv::Mat& image, const std::vector<int>& parameters) {
  const auto codecs = plugin<CodecPlugin>();
  if (!codecs) return tl::unexpected(codecs.error());
  std::vector<uint8_t> bytes;
  try {
    if (!(*codecs)->encode(ending, image, parameters, bytes)) return fail("it can't be coded as " + ending);
  } catch (const cv::Exception& error) {
    return fail("it can't be coded as " + ending + ": " + error.err);
  }
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace covis::io
