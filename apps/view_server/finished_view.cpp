// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/finished_view.h"

#include <cstdio>
#include <fstream>
#include <iterator>
#include <utility>

namespace covis::view {

FinishedView::FinishedView(ViewState state, std::filesystem::path images)
    : state_(std::move(state)), images_(std::move(images)) {}

std::optional<std::string> FinishedView::key_frame_image(const KeyFrameRow& key_frame) {
  if (images_.empty()) return std::nullopt;
  char name[16];
  std::snprintf(name, sizeof name, "%06u", key_frame.id);
  for (const char* extension : {".jpg", ".jpeg", ".png"}) {
    std::ifstream file(images_ / (std::string(name) + extension), std::ios::binary);
    if (file) return std::string(std::istreambuf_iterator<char>(file), {});
  }
  return std::nullopt;
}

}  // namespace covis::view
