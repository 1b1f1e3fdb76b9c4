// SPDX-License-Identifier: Apache-2.0
// A map or a finished run that is shown.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "apps/view_server/server.h"

namespace covis::view {

class FinishedView : public ViewSource {
 public:
  // images: a folder with files 000012.jpg or .png, named by the ids of key frames; it may be missing.
  FinishedView(ViewState state, std::filesystem::path images);
  const ViewState& refresh() override { return state_; }
  std::optional<std::string> key_frame_image(const KeyFrameRow& key_frame) override;

 private:
  const ViewState state_;
  const std::filesystem::path images_;
};

}  // namespace covis::view
