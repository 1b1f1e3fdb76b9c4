// SPDX-License-Identifier: Apache-2.0
// Cameras of Video4Linux, through OpenCV's videoio.
#include <chrono>
#include <cstdlib>
#include <optional>

#include "covis/io/camera_device.h"
#include "covis/io/opencv_capture.h"
#include "covis/io/opencv_picture.h"

namespace covis::io {
namespace {

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

}  // namespace

std::unique_ptr<CameraDevice> make_v4l2_camera(int number, const CameraFile& wanted) {
  return std::make_unique<V4l2Camera>(number, wanted);
}

}  // namespace covis::io
