// SPDX-License-Identifier: Apache-2.0
// Video files, through OpenCV's videoio, and the opening of live cameras. Monocular.
#include <charconv>
#include <cmath>
#include <mutex>
#include <utility>

#include "covis/geometry/camera_check.h"
#include "covis/io/decode_ahead.h"
#include "covis/io/files.h"
#include "covis/io/live_camera.h"
#include "covis/io/opencv_picture.h"
#include "covis/io/plugin.h"
#include "covis/io/sequence_sources.h"
#include "covis/io/video_file.h"

namespace covis::io {
namespace {

// Properties of a stream that are known before its frames are read.
struct Video {
  double rate = 30;        // Hz
  int64_t promised = 0;    // frames that the container says it has; 0: it does not say
  bool has_times = false;  // its frames have times of their own, and no rate is given instead
};

class VideoSequence : public Sequence {
 public:
  VideoSequence(std::unique_ptr<VideoFile> file, std::string name, const Camera& camera, const Video& video,
                int64_t frames, const SequenceOptions& options)
      : file_(std::move(file)),
        name_(std::move(name)),
        camera_(camera),
        video_(video),
        frames_(frames),
        options_(options),
        ahead_([this](Frame memory) { return decode(std::move(memory)); }, options.decode_ahead) {}

  SequenceKind kind() const override { return SequenceKind::video; }
  Sensor sensor() const override { return Sensor::monocular; }
  const Camera& camera() const override { return camera_; }
  int64_t size() const override { return frames_; }
  double frame_rate() const override { return video_.rate / static_cast<double>(options_.stride); }
  std::optional<Truth> truth() const override { return std::nullopt; }
  std::vector<std::string> notes() const override {
    const std::lock_guard lock(notes_mutex_);
    return notes_;
  }
  std::string description() const override {
    return "video " + name_ + ", " + std::to_string(camera_.width) + "x" + std::to_string(camera_.height) + ", " +
           std::to_string(video_.rate) + " Hz";
  }
  Result<std::optional<Frame>> next(Frame recycled) override { return ahead_.next(std::move(recycled)); }
  Result<Picture> picture(int64_t frame) override {
    if (!again_ || frame < next_again_) {
      auto opened = open_video_file(name_);
      if (!opened) return tl::unexpected(opened.error());
      again_ = std::move(*opened);
      next_again_ = 0;
    }
    for (; next_again_ <= frame; ++next_again_) {
      if (!again_ || !again_->grab()) {
        again_.reset();
        return fail(name_ + ": frame " + std::to_string(frame) + " can't be read again");
      }
    }
    cv::Mat image;
    if (!again_->retrieve(image)) return fail(name_ + ": frame " + std::to_string(frame) + " can't be decoded");
    return picture_of(image);
  }
  bool may_have_colours(int64_t) const override { return true; }

 private:
  Result<std::optional<Frame>> decode(Frame frame) {
    if (options_.count >= 0 && given_ >= options_.count) return std::optional<Frame>();
    while (read_ < options_.first || (read_ - options_.first) % options_.stride != 0) {
      if (!file_->grab()) {
        if (read_ < options_.first && !std::exchange(said_, true)) return too_short();
        return end();
      }
      ++read_;
    }
    if (!file_->grab()) return end();
    const int64_t index = read_++;
    if (!file_->retrieve(picture_)) return fail(name_ + ": frame " + std::to_string(index) + " can't be decoded");
    ++given_;
    if (picture_.cols != camera_.width || picture_.rows != camera_.height) {
      return fail(name_ + ": frame " + std::to_string(index) + " is " + std::to_string(picture_.cols) + "x" +
                  std::to_string(picture_.rows) + ", the camera " + std::to_string(camera_.width) + "x" +
                  std::to_string(camera_.height));
    }
    to_grey(picture_, frame.image);
    frame.index = index;
    frame.stamp = stamp_of(index);
    return std::optional<Frame>(std::move(frame));
  }

  // Stamp of the frame that was grabbed last: from the container's own times where it has them and no rate
  // is given, so that frames that are missing leave a gap.
  Timestamp stamp_of(int64_t index) {
    const auto by_rate = [&](int64_t i) { return from_seconds(static_cast<double>(i) / video_.rate); };
    Timestamp stamp = by_rate(index);
    if (video_.has_times) {
      constexpr double kLongest = 1e12;  // milliseconds
      const double time = file_->time();
      const Timestamp told = time >= 0 && time < kLongest ? static_cast<Timestamp>(std::llround(time * 1e6)) : 0;
      stamp = last_index_ < 0 || told > last_stamp_ ? told : last_stamp_ + by_rate(index - last_index_);
    }
    last_index_ = index;
    last_stamp_ = stamp;
    return stamp;
  }

  tl::unexpected<Error> too_short() const {
    return fail(name_ + ": it has " + std::to_string(read_) + " frames; none is left from frame " +
                std::to_string(options_.first) + " on");
  }

  // A video with fewer frames than its container says gets a note and no error, for containers without a list of frames
  // (WebM, Matroska, a rate that varies) tell no more than a guess.
  std::optional<Frame> end() {
    if (read_ >= video_.promised || said_) return std::nullopt;
    said_ = true;
    const std::lock_guard lock(notes_mutex_);
    notes_.push_back(name_ + ": the container promises " + std::to_string(video_.promised) + " frames, and " +
                     std::to_string(read_) +
                     " came; it may be cut short or damaged behind them, or its promise a mere estimate");
    return std::nullopt;
  }

  const std::unique_ptr<VideoFile> file_;
  const std::string name_;
  const Camera camera_;
  const Video video_;
  const int64_t frames_;
  const SequenceOptions options_;
  int64_t read_ = 0, given_ = 0;
  int64_t last_index_ = -1;
  Timestamp last_stamp_ = 0;
  bool said_ = false;  // a note or an error tells of the end
  mutable std::mutex notes_mutex_;
  std::vector<std::string> notes_;  // guarded by notes_mutex_
  cv::Mat picture_;
  // Used by picture() only: the video once more, and the next frame it gives.
  std::unique_ptr<VideoFile> again_;
  int64_t next_again_ = 0;
  DecodeAhead ahead_;  // last member: its thread uses the others
};

// Returns the number of frames to come; -1 when the file does not contain it.
int64_t count_frames(int64_t promised, const SequenceOptions& options) {
  if (promised == 0) return -1;
  const int64_t frames = std::max<int64_t>(0, (promised - options.first + options.stride - 1) / options.stride);
  return options.count >= 0 ? std::min(frames, options.count) : frames;
}

std::optional<int> camera_number(const std::string& path) {
  int number = 0;
  const auto [end, error] = std::from_chars(path.data(), path.data() + path.size(), number);
  if (error != std::errc() || end != path.data() + path.size() || number < 0) return std::nullopt;
  return number;
}

// Checks the camera file's size against that of the images, where those are known, and takes it from them if there is
// no camera file.
Result<void> settle_size(const std::string& path, const CameraFile& given, int width, int height, Camera& camera) {
  if (camera.width == 0) {
    if (width <= 0 || height <= 0) return fail(path + ": the video does not say how large its images are");
    camera.width = width;
    camera.height = height;
  }
  if (width > 0 && height > 0 && (width != camera.width || height != camera.height)) {
    return fail(path + ": the images are " + std::to_string(width) + "x" + std::to_string(height) + ", the camera of " +
                given.file.string() + " is " + std::to_string(camera.width) + "x" + std::to_string(camera.height));
  }
  return {};
}

double settle_rate(double given, double told) {
  const double rate = given > 0 ? given : told;
  return rate > 0.01 && rate < 10000 ? rate : 30;
}

Result<void> serves(const std::string& path, const Request& request) {
  if (request.wanted && *request.wanted != Sensor::monocular)
    return fail(path + ": a video or a camera serves --sensor mono only");
  return {};
}

}  // namespace

Result<std::unique_ptr<Sequence>> open_video(const std::string& path, const Request& request,
                                             const SequenceOptions& options) {
  if (const auto served = serves(path, request); !served) return tl::unexpected(served.error());
  if (!request.given && !request.uncalibrated) return tl::unexpected(no_calibration(path, "--camera"));
  const CameraFile given = request.given.value_or(CameraFile());
  if (!is_regular(path)) return fail(path + ": it is no regular file; a video file is expected, or a camera's number");
  auto file = open_video_file(path);
  if (!file) return tl::unexpected(file.error());
  if (!*file) return fail(path + ": it is not a video that can be read");
  Camera camera = given.camera;
  camera.pinhole.bf = 0;
  const VideoFile::Properties properties = (*file)->properties();
  if (const auto settled = settle_size(path, given, properties.width, properties.height, camera); !settled)
    return tl::unexpected(settled.error());
  if (const auto problem = request.given ? problem_of(camera) : std::nullopt)
    return fail(given.file.string() + ": " + *problem);
  const Video video{.rate = settle_rate(given.fps, properties.rate),
                    .promised = properties.frames,
                    .has_times = !(given.fps > 0) && properties.has_times};
  const int64_t frames = count_frames(properties.frames, options);
  return std::make_unique<VideoSequence>(std::move(*file), path, camera, video, frames, options);
}

Result<std::unique_ptr<Sequence>> open_camera(const std::string& path, const Request& request,
                                              const SequenceOptions& options) {
  if (const auto served = serves(path, request); !served) return tl::unexpected(served.error());
  const std::optional<int> number = camera_number(path);
  if (!number) return fail(path + ": a camera is named by its number: 0, 1 …");
  if (!request.given) {
    return fail(path +
                ": a live camera needs a camera file, --camera FILE: its lens can't be looked for before the run, "
                "because its images can't be played again. covis calibrate makes one, or covis run on a video that the "
                "camera took");
  }
  const auto cameras = plugin<VideoPlugin>();
  if (!cameras) return fail(path + ": " + cameras.error().message);
  std::unique_ptr<CameraDevice> device = (*cameras)->make_camera(*number, *request.given);
  const auto format = device->open();
  if (!format) return fail(path + ": " + format.error().message);
  LiveCamera::Setup setup{.name = path, .camera = request.given->camera, .options = options};
  setup.camera.pinhole.bf = 0;
  if (const auto settled = settle_size(path, *request.given, format->width, format->height, setup.camera); !settled)
    return tl::unexpected(settled.error());
  if (const auto problem = problem_of(setup.camera)) return fail(request.given->file.string() + ": " + *problem);
  setup.rate = settle_rate(request.given->fps, format->fps);
  return std::make_unique<LiveCamera>(std::move(device), std::move(setup));
}

}  // namespace covis::io
