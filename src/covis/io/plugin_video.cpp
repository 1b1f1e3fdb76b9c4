// SPDX-License-Identifier: Apache-2.0
// The plug-in covis_video: videos and cameras of Video4Linux, through OpenCV's videoio.
#include <chrono>
#include <cstdlib>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "covis/io/opencv_picture.h"
#include "covis/io/plugin.h"
#include "covis/io/video_file.h"

namespace covis::io {
namespace {

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

class OpenCvVideo : public VideoFile {
 public:
  explicit OpenCvVideo(cv::VideoCapture capture) : capture_(std::move(capture)) {}

  Properties properties() const override {
    const double frames = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    const auto codec = static_cast<int>(capture_.get(cv::CAP_PROP_FOURCC));
    const bool ffmpeg = capture_.getBackendName() == "FFMPEG";
    return {static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
            static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT)), capture_.get(cv::CAP_PROP_FPS),
            frames > 0 && frames < 1e12 ? static_cast<int64_t>(frames) : 0,
            // OpenCV's own reader of AVI files tells the time of the frame after.
            ffmpeg, ffmpeg && (codec == fourcc("MJPG") || codec == fourcc("mjpg") || codec == fourcc("jpeg"))};
  }
  bool grab() override { return capture_.grab(); }
  bool retrieve(cv::Mat& picture) override { return capture_.retrieve(picture) && !picture.empty(); }
  double time() const override { return capture_.get(cv::CAP_PROP_POS_MSEC); }

 private:
  static int fourcc(const char* c) { return cv::VideoWriter::fourcc(c[0], c[1], c[2], c[3]); }

  cv::VideoCapture capture_;
};

std::unique_ptr<VideoFile> open_file(const std::string& path, VideoPlugin::Give give) {
  // Only the suitable back ends are tried, because a search through all of them takes longer and leaks memory.
  cv::VideoCapture capture = open_quietly([&](cv::VideoCapture& opened) {
    if (!opened.open(path, cv::CAP_FFMPEG)) opened.open(path, cv::CAP_OPENCV_MJPEG);
  });
  if (!capture.isOpened()) return nullptr;
  if (give == VideoPlugin::Give::packets && !capture.set(cv::CAP_PROP_FORMAT, -1)) return nullptr;
  return std::make_unique<OpenCvVideo>(std::move(capture));
}

class V4l2Camera : public CameraDevice {
 public:
  V4l2Camera(int number, const CameraFile& wanted)
      : number_(number), width_(wanted.camera.width), height_(wanted.camera.height), fps_(wanted.fps) {
    // The seconds after which OpenCV takes a silent camera for gone, 10 by default: too long for who ends the program.
    setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "1", 0);
  }

  Result<Format> open() override {
    // A search through all back ends would take longer, and leaks memory.
    capture_ = open_quietly([this](cv::VideoCapture& capture) { capture.open(number_, cv::CAP_V4L2); });
    if (!capture_.isOpened()) return fail("the camera can't be opened");
    capture_.set(cv::CAP_PROP_FRAME_WIDTH, width_);
    capture_.set(cv::CAP_PROP_FRAME_HEIGHT, height_);
    if (fps_ > 0) capture_.set(cv::CAP_PROP_FPS, fps_);
    return Format{static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
                  static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT)), capture_.get(cv::CAP_PROP_FPS)};
  }
  void close() override { capture_.release(); }

  Result<Timestamp> grab() override {
    try {
      if (!capture_.grab()) return fail("no image comes from the camera");
    } catch (const cv::Exception& error) {
      return fail(error.err);
    }
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  }

  Result<void> retrieve(ImageU8& grey) override {
    try {
      if (!capture_.retrieve(picture_) || picture_.empty()) return fail("it can't be decoded");
      to_grey(picture_, grey);
    } catch (const cv::Exception& error) {
      return fail("it can't be decoded: " + error.err);
    }
    return {};
  }

 private:
  const int number_, width_, height_;
  const double fps_;
  cv::VideoCapture capture_;
  cv::Mat picture_;
};

std::unique_ptr<CameraDevice> make_camera(int number, const CameraFile& wanted) {
  return std::make_unique<V4l2Camera>(number, wanted);
}

}  // namespace
COVIS_PLUGIN(VideoPlugin, open_file, make_camera)

}  // namespace covis::io
