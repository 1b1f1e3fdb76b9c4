// SPDX-License-Identifier: Apache-2.0
// A map or a finished run that is shown.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "apps/view_server/server.h"
#include "covis/exchange/kept_images.h"

namespace covis::view {

class FinishedView : public ViewSource {
 public:
  // images: the folder that `covis run --keep-images` left; it may be missing.
  FinishedView(ViewState state, const std::filesystem::path& images);
  const ViewState& refresh() override { return state_; }
  std::optional<std::string> key_frame_image(const KeyFrameRow& key_frame) override;

 private:
  const ViewState state_;
  std::optional<exchange::KeptImages> images_;
  bool problem_logged_ = false;  // that an image can't be shown
};

}  // namespace covis::view
