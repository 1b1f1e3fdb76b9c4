// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/image_store.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "covis/io/codecs.h"
#include "covis/io/opencv_picture.h"

namespace covis::view {
namespace {

Result<std::string> small_jpeg(const cv::Mat& full, int width) {
  cv::Mat small = full;
  if (full.cols > width) {
    const int height = std::max(1, full.rows * width / full.cols);
    cv::resize(full, small, {width, height}, 0, 0, cv::INTER_AREA);
  }
  return io::encode_image(".jpg", small, {cv::IMWRITE_JPEG_QUALITY, 80});
}

}  // namespace

RawImage::RawImage(int32_t frame_index, ImageView<const uint8_t> image)
    : frame(frame_index), grey(image.width, image.height) {
  for (int y = 0; y < image.height; ++y) std::copy_n(image.row(y), image.width, grey.view().row(y));
}

Result<std::string> jpeg_of(ImageView<const uint8_t> image, int width) {
  if (image.empty()) return std::string();
  return small_jpeg(
      {image.height, image.width, CV_8U, const_cast<uint8_t*>(image.data), static_cast<size_t>(image.stride)}, width);
}

Result<std::string> jpeg_of(const io::Picture& picture, int width) {
  if (picture.channels == 0) return std::string();
  return small_jpeg(io::mat_of(picture), width);
}

void ImageStore::put(int32_t frame, std::string jpeg) {
  std::string& image = images_[frame];
  bytes_ += jpeg.size() - image.size();
  image = std::move(jpeg);
  while (bytes_ > most_bytes_ && images_.size() > 1) {
    bytes_ -= images_.begin()->second.size();
    images_.erase(images_.begin());
  }
}

std::optional<std::string> ImageStore::get(int32_t frame) const {
  const auto found = images_.find(frame);
  if (found == images_.end()) return std::nullopt;
  return found->second;
}

}  // namespace covis::view
