// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/finished_view.h"

#include <utility>

#include "apps/view_server/image_store.h"
#include "covis/core/log.h"
#include "covis/io/files.h"
#include "covis/io/images.h"

namespace covis::view {
namespace {

constexpr int kWidth = 1280;  // pixels, of an image that is encoded anew

// Kept images are files as they were recorded, of formats that no browser decodes among them.
bool browsers_decode(const std::string& bytes) { return bytes.starts_with("\x89PNG") || bytes.starts_with("\xff\xd8"); }

Result<std::string> as_jpeg(const std::filesystem::path& file) {
  const auto picture = io::read_picture(file);
  if (!picture) return tl::unexpected(picture.error());
  auto jpeg = jpeg_of(*picture, kWidth);
  if (!jpeg) return fail(file.string() + ": " + jpeg.error().message);
  return jpeg;
}

}  // namespace

FinishedView::FinishedView(ViewState state, const std::filesystem::path& images) : state_(std::move(state)) {
  auto kept = exchange::KeptImages::read(images);
  if (kept) images_ = std::move(*kept);
}

std::optional<std::string> FinishedView::key_frame_image(const KeyFrameRow& key_frame) {
  const auto file = images_ ? images_->find(key_frame.id, from_seconds(key_frame.stamp)) : std::filesystem::path();
  std::string bytes;
  if (file.empty() || !io::read_bytes(file, bytes)) return std::nullopt;
  if (browsers_decode(bytes)) return bytes;
  auto jpeg = as_jpeg(file);
  if (jpeg) return std::move(*jpeg);
  if (!std::exchange(problem_logged_, true))
    log(LogLevel::warning, "viewer: it can't show an image: " + jpeg.error().message);
  return std::nullopt;
}

}  // namespace covis::view
