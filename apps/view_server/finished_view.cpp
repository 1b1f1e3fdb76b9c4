// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/finished_view.h"

#include <utility>

#include "covis/io/files.h"

namespace covis::view {

FinishedView::FinishedView(ViewState state, const std::filesystem::path& images) : state_(std::move(state)) {
  auto kept = exchange::KeptImages::read(images);
  if (kept) images_ = std::move(*kept);
}

std::optional<std::string> FinishedView::key_frame_image(const KeyFrameRow& key_frame) {
  const auto file = images_ ? images_->find(key_frame.id, from_seconds(key_frame.stamp)) : std::filesystem::path();
  std::string bytes;
  if (file.empty() || !io::read_bytes(file, bytes)) return std::nullopt;
  return bytes;
}

}  // namespace covis::view
