// SPDX-License-Identifier: Apache-2.0
#include "covis/io/images.h"

#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "covis/io/files.h"

namespace covis::io {
namespace {

// OpenCV decodes a file that was cut short and fills up with grey: look for the end mark of PNG and JPEG files first.
bool cut_short(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG"))
    return bytes.size() < 20 ||
           bytes.substr(bytes.size() - std::min<size_t>(bytes.size(), 64)).find("IEND") == std::string_view::npos;
  if (bytes.starts_with("\xff\xd8")) return bytes.rfind("\xff\xd9") == std::string_view::npos;
  return false;
}

Result<cv::Mat> decode(const std::filesystem::path& file, int flags) {
  const auto bytes = read_text(file);
  if (!bytes) return tl::unexpected(bytes.error());
  if (bytes->empty()) return fail(file.string() + ": the image file is empty");
  if (cut_short(*bytes))
    return fail(file.string() + ": the image file is cut short (" + std::to_string(bytes->size()) + " bytes)");
  const cv::Mat buffer(1, static_cast<int>(bytes->size()), CV_8U, const_cast<char*>(bytes->data()));
  cv::Mat image;
  try {
    image = cv::imdecode(buffer, flags);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) return fail(file.string() + ": it is not an image that can be read (PNG, JPEG, TIFF, BMP, PGM …)");
  return image;
}

}  // namespace

Result<void> read_grey(const std::filesystem::path& file, ImageU8& image) {
  const auto decoded = decode(file, cv::IMREAD_GRAYSCALE);
  if (!decoded) return tl::unexpected(decoded.error());
  image.resize(decoded->cols, decoded->rows);
  for (int y = 0; y < decoded->rows; ++y)
    std::memcpy(image.row(y), decoded->ptr(y), static_cast<size_t>(decoded->cols));
  return {};
}

Result<void> read_depth(const std::filesystem::path& file, double scale, ImageF& depth) {
  const auto decoded = decode(file, cv::IMREAD_UNCHANGED);
  if (!decoded) return tl::unexpected(decoded.error());
  depth.resize(decoded->cols, decoded->rows);
  const auto inverse = static_cast<float>(1 / scale);
  for (int y = 0; y < decoded->rows; ++y) {
    float* out = depth.row(y);
    if (decoded->type() == CV_16UC1) {
      const auto* in = decoded->ptr<uint16_t>(y);
      for (int x = 0; x < decoded->cols; ++x) out[x] = static_cast<float>(in[x]) * inverse;
    } else if (decoded->type() == CV_32FC1) {
      std::memcpy(out, decoded->ptr(y), static_cast<size_t>(decoded->cols) * sizeof(float));
    } else {
      return fail(file.string() + ": a depth image must have one channel of 16 bits or of 32-bit float");
    }
  }
  return {};
}

}  // namespace covis::io
