// SPDX-License-Identifier: Apache-2.0
// Video files and cameras, through OpenCV's videoio. Monocular.
#include <charconv>
#include <chrono>
#include <cstring>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "covis/io/decode_ahead.h"
#include "covis/io/opencv_picture.h"
#include "covis/io/sequence_sources.h"

namespace covis::io {
namespace {

// OpenCV's own warnings about failed attempts are less helpful than our message. Only the suitable back ends are tried,
// because a search through all of them takes longer and leaks memory.
cv::VideoCapture open_quietly(const std::string& path, std::optional<int> number) {
  namespace logging = cv::utils::logging;
  const logging::LogLevel before = logging::setLogLevel(logging::LOG_LEVEL_SILENT);
  cv::VideoCapture capture;
  try {
    if (number) {
      capture.open(*number, cv::CAP_V4L2);
    } else if (!capture.open(path, cv::CAP_FFMPEG)) {
      capture.open(path, cv::CAP_OPENCV_MJPEG);
    }
  } catch (const cv::Exception&) {
    capture.release();
  }
  logging::setLogLevel(before);
  return capture;
}

class CaptureSequence : public Sequence {
 public:
  CaptureSequence(cv::VideoCapture capture, std::string name, SequenceKind kind, const Camera& camera, double rate,
                  int64_t frames, const SequenceOptions& options)
      : capture_(std::move(capture)),
        name_(std::move(name)),
        kind_(kind),
        camera_(camera),
        rate_(rate),
        frames_(frames),
        options_(options),
        // A camera does not wait for the program: only its latest frame is used.
        ahead_([this](Frame memory) { return decode(std::move(memory)); },
               kind == SequenceKind::camera ? 1 : options.decode_ahead,
               kind == SequenceKind::camera ? DecodeAhead::WhenFull::drop_old : DecodeAhead::WhenFull::wait) {}

  SequenceKind kind() const override { return kind_; }
  Sensor sensor() const override { return Sensor::monocular; }
  const Camera& camera() const override { return camera_; }
  int64_t size() const override { return frames_; }
  double frame_rate() const override { return rate_; }
  std::optional<Truth> truth() const override { return std::nullopt; }
  std::vector<std::string> notes() const override { return {}; }
  std::string description() const override {
    return (kind_ == SequenceKind::camera ? "camera " : "video ") + name_ + ", " + std::to_string(camera_.width) + "x" +
           std::to_string(camera_.height) + ", " + std::to_string(rate_) + " Hz";
  }
  Result<std::optional<Frame>> next(Frame recycled) override { return ahead_.next(std::move(recycled)); }
  Result<Picture> picture(int64_t frame) override {
    if (kind_ == SequenceKind::camera) return fail(name_ + ": a camera's frames can't be read again");
    if (!again_ || frame < next_again_) {
      again_ = open_quietly(name_, std::nullopt);
      next_again_ = 0;
    }
    for (; next_again_ <= frame; ++next_again_) {
      if (!again_->grab()) {
        again_.reset();
        return fail(name_ + ": frame " + std::to_string(frame) + " can't be read again");
      }
    }
    cv::Mat image;
    if (!again_->retrieve(image) || image.empty())
      return fail(name_ + ": frame " + std::to_string(frame) + " can't be decoded");
    return picture_of(image);
  }
  bool may_have_colours(int64_t) const override { return kind_ != SequenceKind::camera; }

 private:
  Result<std::optional<Frame>> decode(Frame frame) {
    if (options_.count >= 0 && given_ >= options_.count) return std::optional<Frame>();
    while (read_ < options_.first || (read_ - options_.first) % options_.stride != 0) {
      if (!capture_.grab()) return std::optional<Frame>();
      ++read_;
    }
    const int64_t index = read_++;
    if (!capture_.grab()) return std::optional<Frame>();
    const Timestamp now =
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
            .count();
    if (!capture_.retrieve(picture_) || picture_.empty())
      return fail(name_ + ": frame " + std::to_string(index) + " can't be decoded");
    ++given_;
    if (picture_.cols != camera_.width || picture_.rows != camera_.height) {
      return fail(name_ + ": frame " + std::to_string(index) + " is " + std::to_string(picture_.cols) + "x" +
                  std::to_string(picture_.rows) + ", the camera " + std::to_string(camera_.width) + "x" +
                  std::to_string(camera_.height));
    }
    if (picture_.channels() == 1) {
      grey_ = picture_;
    } else {
      cv::cvtColor(picture_, grey_, picture_.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
    }
    frame.index = index;
    frame.stamp = kind_ == SequenceKind::camera ? now : from_seconds(static_cast<double>(index) / rate_);
    frame.image.resize(grey_.cols, grey_.rows);
    for (int y = 0; y < grey_.rows; ++y) std::memcpy(frame.image.row(y), grey_.ptr(y), static_cast<size_t>(grey_.cols));
    return std::optional<Frame>(std::move(frame));
  }

  cv::VideoCapture capture_;
  const std::string name_;
  const SequenceKind kind_;
  const Camera camera_;
  const double rate_;
  const int64_t frames_;
  const SequenceOptions options_;
  int64_t read_ = 0, given_ = 0;
  cv::Mat picture_, grey_;
  // Used by picture() only: the video once more, and the next frame it gives.
  std::optional<cv::VideoCapture> again_;
  int64_t next_again_ = 0;
  DecodeAhead ahead_;  // last member: its thread uses the others
};

// Returns the number of frames to come; -1 when the file does not contain it.
int64_t count_frames(const cv::VideoCapture& capture, const SequenceOptions& options) {
  const double all = capture.get(cv::CAP_PROP_FRAME_COUNT);
  if (!(all > 0 && all < 1e12)) return -1;
  const int64_t frames =
      std::max<int64_t>(0, (static_cast<int64_t>(all) - options.first + options.stride - 1) / options.stride);
  return options.count >= 0 ? std::min(frames, options.count) : frames;
}

std::optional<int> camera_number(const std::string& path) {
  int number = 0;
  const auto [end, error] = std::from_chars(path.data(), path.data() + path.size(), number);
  if (error != std::errc() || end != path.data() + path.size() || number < 0) return std::nullopt;
  return number;
}

}  // namespace

Result<std::unique_ptr<Sequence>> open_capture(const std::string& path, SequenceKind kind, const Request& request,
                                               const SequenceOptions& options) {
  const bool live = kind == SequenceKind::camera;
  if (request.wanted && *request.wanted != Sensor::monocular)
    return fail(path + ": a video or a camera serves --sensor mono only");
  if (!request.given && (live || !request.uncalibrated)) return tl::unexpected(no_calibration(path, "--camera"));
  const CameraFile given = request.given.value_or(CameraFile());
  const std::optional<int> number = live ? camera_number(path) : std::nullopt;
  if (live && !number) return fail(path + ": a camera is named by its number: 0, 1 …");
  cv::VideoCapture capture = open_quietly(path, number);
  if (!capture.isOpened())
    return fail(path + (live ? ": the camera can't be opened" : ": it is not a video that can be read"));
  Camera camera = given.camera;
  camera.pinhole.bf = 0;
  if (live) {
    capture.set(cv::CAP_PROP_FRAME_WIDTH, camera.width);
    capture.set(cv::CAP_PROP_FRAME_HEIGHT, camera.height);
    if (given.fps > 0) capture.set(cv::CAP_PROP_FPS, given.fps);
  }
  const int width = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_WIDTH));
  const int height = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_HEIGHT));
  if (camera.width == 0) {
    if (width <= 0 || height <= 0) return fail(path + ": the video does not say how large its images are");
    camera.width = width;
    camera.height = height;
  }
  if (width > 0 && height > 0 && (width != camera.width || height != camera.height)) {
    return fail(path + ": the images are " + std::to_string(width) + "x" + std::to_string(height) + ", the camera of " +
                given.file.string() + " is " + std::to_string(camera.width) + "x" + std::to_string(camera.height));
  }
  double rate = given.fps > 0 ? given.fps : capture.get(cv::CAP_PROP_FPS);
  if (!(rate > 0.01 && rate < 10000)) rate = 30;
  const int64_t frames = live ? -1 : count_frames(capture, options);
  return std::make_unique<CaptureSequence>(std::move(capture), path, kind, camera, rate, frames, options);
}

}  // namespace covis::io
