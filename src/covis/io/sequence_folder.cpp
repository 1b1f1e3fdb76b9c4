// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "covis/geometry/camera_check.h"
#include "covis/io/codecs.h"
#include "covis/io/decode_ahead.h"
#include "covis/io/files.h"
#include "covis/io/images.h"
#include "covis/io/plugin.h"
#include "covis/io/sequence_sources.h"

namespace covis::io {
namespace {

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

const char* sensor_text(Sensor sensor) {
  return sensor == Sensor::monocular ? "monocular" : sensor == Sensor::stereo ? "stereo" : "RGB-D";
}

std::unique_ptr<ImageSource> image_source(const Recording& recording, const ExpectedSize& expected) {
  std::unique_ptr<ImageSource> source = recording.images ? recording.images() : std::make_unique<ImageReader>();
  source->expect(expected);
  source->use_bits(recording.bits);
  return source;
}

ExpectedSize expected_size(const Recording& recording) {
  return {recording.camera.width, recording.camera.height, recording.calibration};
}

class FolderSequence : public Sequence {
 public:
  FolderSequence(Recording recording, const SequenceOptions& options)
      : recording_(std::move(recording)),
        options_(options),
        images_(image_source(recording_, expected_size(recording_))),
        pictures_(image_source(recording_, expected_size(recording_))),
        ahead_([this](Frame memory) { return decode(std::move(memory)); }, options.decode_ahead) {}

  SequenceKind kind() const override { return recording_.kind; }
  Sensor sensor() const override { return recording_.sensor; }
  const Camera& camera() const override { return recording_.camera; }
  int64_t size() const override { return static_cast<int64_t>(recording_.frames.size()); }
  double frame_rate() const override {
    std::vector<Timestamp> stamps;
    for (const FrameFiles& files : recording_.frames) stamps.push_back(files.stamp);
    return rate_of(stamps).value_or(30);
  }
  std::optional<Truth> truth() const override { return recording_.truth; }
  std::vector<std::string> notes() const override { return recording_.notes; }
  std::vector<std::string> losses() const override { return recording_.losses; }
  std::string description() const override {
    return recording_.name + ", " + sensor_text(recording_.sensor) + ", " + std::to_string(recording_.frames.size()) +
           " frames, " + size_text(recording_.camera.width, recording_.camera.height);
  }
  Result<std::optional<Frame>> next(Frame recycled) override { return ahead_.next(std::move(recycled)); }
  Result<Picture> picture(int64_t frame) override {
    const std::filesystem::path file = file_of(frame);
    if (file.empty()) return fail("frame " + std::to_string(frame) + ": there is none");
    return without_exceptions(file, [&] { return load_picture(file); });
  }
  bool may_have_colours(int64_t frame) const override { return pictures_->may_have_colours(file_of(frame)); }

 private:
  Result<Picture> load_picture(const std::filesystem::path& file) {
    auto picture = pictures_->picture(file);
    if (!picture) return picture;
    if (auto checked = check_size(file, picture->width, picture->height); !checked)
      return tl::unexpected(checked.error());
    if (recording_.rectification) {
      return resampled(*picture,
                       [&](ImageView<const uint8_t> from, ImageU8& to) { recording_.rectification->left(from, to); });
    }
    return picture;
  }

  // Empty for a frame that is not read.
  std::filesystem::path file_of(int64_t frame) const {
    const int64_t at = (frame - options_.first) / options_.stride;
    if (frame < options_.first || at >= size()) return {};
    return recording_.frames[static_cast<size_t>(at)].image;
  }

  // Runs in the decoding thread.
  Result<std::optional<Frame>> decode(Frame memory) {
    if (next_ >= recording_.frames.size()) return std::optional<Frame>();
    const FrameFiles& files = recording_.frames[next_];
    memory.index = options_.first + static_cast<int64_t>(next_) * options_.stride;
    memory.stamp = files.stamp;
    ++next_;
    auto read = without_exceptions(files.image, [&] { return load(files, memory); });
    if (!read) return tl::unexpected(read.error());
    return std::optional<Frame>(std::move(memory));
  }

  Result<void> load(const FrameFiles& files, Frame& frame) {
    if (auto read = load_grey(files.image, frame.image); !read) return read;
    if (files.right.empty()) {
      frame.right = {};  // recycled memory may come from another recording
    } else {
      if (auto read = load_grey(files.right, frame.right); !read) return read;
    }
    if (recording_.rectification) {
      recording_.rectification->left(frame.image.view(), scratch_);
      frame.image.swap(scratch_);
      recording_.rectification->right(frame.right.view(), scratch_);
      frame.right.swap(scratch_);
    }
    if (files.depth.empty()) {
      frame.depth = {};
      return {};
    }
    if (auto read = images_->depth(files.depth, recording_.depth_scale, frame.depth); !read) return read;
    return check_size(files.depth, frame.depth.width(), frame.depth.height());
  }

  Result<void> load_grey(const std::filesystem::path& file, ImageU8& image) {
    if (auto read = images_->grey(file, image); !read) return read;
    return check_size(file, image.width(), image.height());
  }

  Result<void> check_size(const std::filesystem::path& file, int width, int height) const {
    const Camera& c = recording_.camera;
    if (width == c.width && height == c.height) return {};
    return fail(file.string() + ": " + wrong_size(width, height, expected_size(recording_)));
  }

  const Recording recording_;
  const SequenceOptions options_;
  // Used by the decoding thread only.
  size_t next_ = 0;
  const std::unique_ptr<ImageSource> images_;
  ImageU8 scratch_;
  const std::unique_ptr<ImageSource> pictures_;  // used by picture() and may_have_colours() only
  DecodeAhead ahead_;                            // last member: its thread uses the others
};

// Takes the image size from the first readable image when the calibration has none. When the calibration has a size
// that none of a few images match, it belongs to another camera, which is an error.
Result<void> settle_size(Recording& recording) {
  Camera& camera = recording.camera;
  const size_t count = recording.frames.size();
  const std::unique_ptr<ImageSource> reader = image_source(recording, {});
  ImageU8 image;
  if (camera.width == 0) {
    Result<void> read;
    for (const FrameFiles& frame : recording.frames) {
      read = reader->grey(frame.image, image);
      if (!read) continue;
      camera.width = image.width();
      camera.height = image.height();
      return {};
    }
    return read;
  }
  std::string problem;
  for (const size_t k : {size_t{0}, count / 2, count - 1}) {
    const std::filesystem::path& file = recording.frames[k].image;
    if (!reader->grey(file, image)) continue;  // next() will report the error
    if (image.width() == camera.width && image.height() == camera.height) return {};
    problem = file.string() + ": " + wrong_size(image.width(), image.height(), expected_size(recording));
  }
  if (problem.empty()) return {};
  return fail(problem);
}

Result<void> check_camera(const Recording& recording) {
  const Camera& camera = recording.camera;
  const Pinhole& p = camera.pinhole;
  if (p.fx == 0) return {};  // opened uncalibrated
  if (const auto problem = problem_of(camera)) return fail(recording.calibration + ": " + *problem);
  if (recording.sensor != Sensor::stereo) return {};
  if (camera.distortion != Distortion::none)
    return fail(recording.calibration + ": stereo pairs must be rectified already; model must be pinhole");
  if (!(p.bf > 0)) return fail(recording.calibration + ": a stereo pair needs 'baseline', in metres");
  return {};
}

}  // namespace

Result<std::unique_ptr<Sequence>> open_folder(Recording recording, const SequenceOptions& options) {
  Pinhole& pinhole = recording.camera.pinhole;
  if (recording.sensor == Sensor::monocular) pinhole.bf = 0;
  if (recording.sensor == Sensor::rgbd && !(pinhole.bf > 0)) pinhole.bf = pinhole.fx * kVirtualBaseline;
  if (recording.kind != SequenceKind::bag) {
    // Else each image would be reported as one that can't be read.
    if (const auto codecs = plugin<CodecPlugin>(); !codecs) return tl::unexpected(codecs.error());
  }
  if (auto settled = settle_size(recording); !settled) return tl::unexpected(settled.error());
  if (auto checked = check_camera(recording); !checked) return tl::unexpected(checked.error());
  return std::make_unique<FolderSequence>(std::move(recording), options);
}

}  // namespace covis::io
