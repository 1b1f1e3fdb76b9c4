// SPDX-License-Identifier: Apache-2.0
// Videos and cameras that are plugged in, by OpenCV's videoio, which brings FFmpeg and GStreamer: it is in a plug-in.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "covis/core/error.h"
#include "covis/io/camera_device.h"

namespace covis::io {

class VideoFile {
 public:
  // As the container says them; 0 where it does not.
  struct Properties {
    int width = 0, height = 0;  // pixels
    double rate = 0;            // Hz
    int64_t frames = 0;         // number of frames
    bool has_times = false;     // its frames have times of their own
    bool motion_jpeg = false;   // each frame is a JPEG file
  };

  virtual ~VideoFile() = default;
  virtual Properties properties() const = 0;
  // Goes to the next frame. False: there is none.
  virtual bool grab() = 0;
  // Decodes the frame that was grabbed last, grey or with blue first. False: it can't be decoded.
  virtual bool retrieve(cv::Mat& picture) = 0;
  // Time of the frame that was grabbed last, milliseconds.
  virtual double time() const = 0;
};

// Null: the file is not a video that can be read. Frames of Motion JPEG that are damaged, or of another size, can't be
// decoded.
Result<std::unique_ptr<VideoFile>> open_video_file(const std::string& path);

// From the first call on FFmpeg opens the kinds of files that open_video_file knows, and no address. The environment
// says so to it, which must not change while threads run: programs call this before they start any. Else the first
// video does.
void limit_ffmpeg();
// The options of OPENCV_FFMPEG_CAPTURE_OPTIONS that limit it so, and before them those given.
std::string limited_ffmpeg_options(const std::string& given);

// plugin_video.cpp
struct VideoPlugin {
  static constexpr const char *kName = "covis_video", *kPurpose = "reads videos and cameras";
  // The file gives decoded pictures, or in their place the bytes of its packets.
  enum class Give { pictures, packets };
  std::unique_ptr<VideoFile> (*open_file)(const std::string& path, Give give);
  // Makes the device /dev/videoNUMBER, which is asked for the size and the rate of `wanted` whenever it is opened.
  std::unique_ptr<CameraDevice> (*make_camera)(int number, const CameraFile& wanted);
};

}  // namespace covis::io
