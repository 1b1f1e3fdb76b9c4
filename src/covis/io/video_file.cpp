// SPDX-License-Identifier: Apache-2.0
#include "covis/io/video_file.h"

#include "covis/io/plugin.h"

namespace covis::io {

Result<std::unique_ptr<VideoFile>> open_video_file(const std::string& path) {
  const auto videos = plugin<VideoPlugin>();
  if (!videos) return tl::unexpected(videos.error());
  return (*videos)->open_file(path);
}

}  // namespace covis::io
