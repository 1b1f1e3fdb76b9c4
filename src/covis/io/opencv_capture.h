// SPDX-License-Identifier: Apache-2.0
// OpenCV's videoio without its own messages. For .cpp files of this module only.
#pragma once

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>

namespace covis::io {

// Opens by `open(capture)`. OpenCV's own warnings about failed attempts are less helpful than our messages.
template <class Open>
cv::VideoCapture open_quietly(Open open) {
  namespace logging = cv::utils::logging;
  const logging::LogLevel before = logging::setLogLevel(logging::LOG_LEVEL_SILENT);
  cv::VideoCapture capture;
  try {
    open(capture);
  } catch (const cv::Exception&) {
    capture.release();
  }
  logging::setLogLevel(before);
  return capture;
}

}  // namespace covis::io
