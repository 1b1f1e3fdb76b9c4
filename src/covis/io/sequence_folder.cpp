// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "covis/io/decode_ahead.h"
#include "covis/io/images.h"
#include "covis/io/sequence_sources.h"

namespace covis::io {
namespace {

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

const char* sensor_text(Sensor sensor) {
  return sensor == Sensor::monocular ? "monocular" : sensor == Sensor::stereo ? "stereo" : "RGB-D";
}

class FolderSequence : public Sequence {
 public:
  FolderSequence(Recording recording, const SequenceOptions& options)
      : recording_(std::move(recording)),
        options_(options),
        ahead_([this](Frame memory) { return decode(std::move(memory)); }, options.decode_ahead) {}

  SequenceKind kind() const override { return recording_.kind; }
  Sensor sensor() const override { return recording_.sensor; }
  const Camera& camera() const override { return recording_.camera; }
  int64_t size() const override { return static_cast<int64_t>(recording_.frames.size()); }
  double frame_rate() const override {
    const auto& frames = recording_.frames;
    if (frames.size() < 2) return 30;
    std::vector<Timestamp> gaps;
    for (size_t i = 1; i < frames.size(); ++i) gaps.push_back(frames[i].stamp - frames[i - 1].stamp);
    const auto middle = gaps.begin() + static_cast<ptrdiff_t>(gaps.size() / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    return 1e9 / static_cast<double>(std::max<Timestamp>(1, *middle));
  }
  std::optional<Truth> truth() const override { return recording_.truth; }
  std::string description() const override {
    return recording_.name + ", " + sensor_text(recording_.sensor) + ", " + std::to_string(recording_.frames.size()) +
           " frames, " + size_text(recording_.camera.width, recording_.camera.height);
  }
  Result<std::optional<Frame>> next(Frame recycled) override { return ahead_.next(std::move(recycled)); }

 private:
  // In the decoding thread.
  Result<std::optional<Frame>> decode(Frame memory) {
    if (next_ >= recording_.frames.size()) return std::optional<Frame>();
    const FrameFiles& files = recording_.frames[next_];
    memory.index = options_.first + static_cast<int64_t>(next_) * options_.stride;
    memory.stamp = files.stamp;
    ++next_;
    if (auto read = load(files, memory); !read) return tl::unexpected(read.error());
    return std::optional<Frame>(std::move(memory));
  }

  Result<void> load(const FrameFiles& files, Frame& frame) const {
    if (auto read = read_grey(files.image, frame.image); !read) return read;
    if (!files.right.empty()) {
      if (auto read = read_grey(files.right, frame.right); !read) return read;
      if (recording_.rectification) {
        recording_.rectification->left(frame.image);
        recording_.rectification->right(frame.right);
      }
      if (auto sized = check_size(files.right, frame.right.width(), frame.right.height()); !sized) return sized;
    }
    if (!files.depth.empty()) {
      if (auto read = read_depth(files.depth, recording_.depth_scale, frame.depth); !read) return read;
      if (auto sized = check_size(files.depth, frame.depth.width(), frame.depth.height()); !sized) return sized;
    }
    return check_size(files.image, frame.image.width(), frame.image.height());
  }

  Result<void> check_size(const std::filesystem::path& file, int width, int height) const {
    const Camera& c = recording_.camera;
    if (width == c.width && height == c.height) return {};
    return fail(file.string() + ": the image is " + size_text(width, height) + ", the camera " +
                size_text(c.width, c.height));
  }

  const Recording recording_;
  const SequenceOptions options_;
  size_t next_ = 0;
  DecodeAhead ahead_;  // last: its thread uses the rest
};

}  // namespace

Result<std::unique_ptr<Sequence>> open_folder(Recording recording, const SequenceOptions& options) {
  Camera& camera = recording.camera;
  if (camera.width == 0) {  // the calibration does not say: the first image that can be read does
    ImageU8 image;
    Result<void> read;
    for (const FrameFiles& frame : recording.frames) {
      read = read_grey(frame.image, image);
      if (read) break;
    }
    if (!read) return tl::unexpected(read.error());
    camera.width = image.width();
    camera.height = image.height();
  }
  const Pinhole& p = camera.pinhole;
  if (!(p.cx > 0 && p.cx < camera.width && p.cy > 0 && p.cy < camera.height)) {
    return fail("camera: the principal point (" + std::to_string(p.cx) + ", " + std::to_string(p.cy) +
                ") must lie inside the image of " + size_text(camera.width, camera.height));
  }
  return std::make_unique<FolderSequence>(std::move(recording), options);
}

}  // namespace covis::io
