// SPDX-License-Identifier: Apache-2.0
// For tests of the whole system: rendered recordings with exact truth.
#pragma once

#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "covis/geometry/alignment.h"
#include "covis/slam/system.h"
#include "covis/vocabulary/vocabulary.h"
#include "synth/synth.h"

namespace covis {

inline std::string sensor_name(Sensor sensor) {
  return sensor == Sensor::monocular ? "mono" : sensor == Sensor::stereo ? "stereo" : "rgbd";
}

struct Size {
  int width = 320, height = 240;
};

// A cache of rendered frames: rendering takes most of a test's time under the sanitizers.
class Recording {
 public:
  explicit Recording(Sensor sensor, int frames, double fps = 8, const std::string& world = "room", Size size = {},
                     double distortion = 0, int light = 0)
      : Recording(options(sensor, world, frames, fps, size, distortion, light)) {}
  explicit Recording(const SynthOptions& options)
      : synth(std::move(Synth::create(options).value())), frames_(static_cast<size_t>(synth.frames())) {}

  int size() const { return static_cast<int>(frames_.size()); }
  System::Input frame(int i) {
    Images& images = frames_[static_cast<size_t>(i)];
    if (images.left.empty()) render(i, images);
    return input(i, images);
  }
  // Returns a black image, as with the lens covered.
  System::Input black(int i) {
    if (black_.left.empty()) render(0, black_);
    for (ImageU8* image : {&black_.left, &black_.right}) {
      if (!image->empty()) std::memset(image->row(0), 0, static_cast<size_t>(image->stride() * image->height()));
    }
    return input(i, black_);
  }

  Synth synth;

 private:
  struct Images {
    ImageU8 left, right;
    ImageF depth;
  };

  static SynthOptions options(Sensor sensor, const std::string& world, int frames, double fps, Size size,
                              double distortion, int light) {
    SynthOptions options;
    options.distortion = distortion;
    options.light = light;
    options.world = world;
    options.sensor = sensor_name(sensor);
    options.frames = frames;
    options.fps = fps;
    options.width = size.width;
    options.height = size.height;
    options.noise = 2;
    return options;
  }
  void render(int i, Images& images) {
    synth.render(i, images.left, synth.sensor() == Sensor::stereo ? &images.right : nullptr,
                 synth.sensor() == Sensor::rgbd ? &images.depth : nullptr);
  }
  System::Input input(int i, const Images& images) const {
    return {.frame = i,
            .stamp = synth.stamp(i),
            .image = images.left.view(),
            .right = images.right.view(),
            .depth = images.depth.view()};
  }

  std::vector<Images> frames_;
  Images black_;
};

// Returns the recording that cases of one program share: each of its frames is rendered once, whoever asks first.
inline Recording& shared_recording(Sensor sensor, int frames, double fps = 8, const std::string& world = "room",
                                   Size size = {}) {
  static std::map<std::tuple<Sensor, int, double, std::string, int, int>, Recording> made;
  const std::tuple key(sensor, frames, fps, world, size.width, size.height);
  const auto at = made.find(key);
  return at != made.end() ? at->second : made.emplace(key, Recording(sensor, frames, fps, world, size)).first->second;
}

inline SystemOptions options_for(Sensor sensor) {
  SystemOptions options;
  options.sensor = sensor;
  return options;
}

// Root mean square distance to the ground truth after the best alignment (with scale when monocular), metres. truth:
// maps a frame's number to its pose.
template <class Truth>
double error_to(const std::vector<PoseOfFrame>& poses, Truth truth, bool with_scale) {
  std::vector<Eigen::Vector3d> estimate, wanted;
  for (const PoseOfFrame& pose : poses) {
    estimate.push_back(pose.T_wc.t());
    wanted.push_back(truth(pose.frame).t());
  }
  const auto alignment = align(estimate, wanted, with_scale ? Scale::free : Scale::fixed);
  return alignment ? alignment->rmse : std::numeric_limits<double>::quiet_NaN();
}
inline double error(const std::vector<PoseOfFrame>& poses, const Synth& synth, bool with_scale) {
  return error_to(
      poses, [&](int64_t frame) { return synth.T_wc(static_cast<int>(frame)); }, with_scale);
}

inline double angle_deg(const SE3& a, const SE3& b) {
  return so3_log(a.R() * b.R().transpose()).norm() * 180 / std::numbers::pi;
}

// Returns the vocabulary that ships with Covis.
inline std::shared_ptr<const Vocabulary> vocabulary() {
  static const auto loaded = Vocabulary::load(std::filesystem::path(COVIS_SOURCE_DIR) / "vocabulary/default.covis-voc");
  return loaded.value();
}

// Returns the bytes of a trajectory, which are equal only when every bit is.
inline std::string bytes(const std::vector<PoseOfFrame>& poses) {
  std::string text;
  for (const PoseOfFrame& pose : poses) {
    text.append(reinterpret_cast<const char*>(pose.T_wc.R().data()), sizeof(double) * 9);
    text.append(reinterpret_cast<const char*>(pose.T_wc.t().data()), sizeof(double) * 3);
  }
  return text;
}

}  // namespace covis
