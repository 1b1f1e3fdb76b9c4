// SPDX-License-Identifier: Apache-2.0
// For tests of the command: a rendered recording as a video.
#pragma once

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "command.h"

namespace covis {

// Writes the recording's images as an AVI file of JPEG frames.
inline void write_video(const fs::path& recording, const fs::path& video, double fps) {
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(recording / "images")) images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  ASSERT_FALSE(images.empty());
  cv::VideoWriter writer(video.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), fps,
                         cv::imread(images.front().string()).size());
  ASSERT_TRUE(writer.isOpened());
  for (const fs::path& image : images) writer.write(cv::imread(image.string(), cv::IMREAD_COLOR));
}

}  // namespace covis
