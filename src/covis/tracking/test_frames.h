// SPDX-License-Identifier: Apache-2.0
// For tests: frames of a rendered desk with their exact poses.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "covis/features/frontend.h"
#include "covis/map/map.h"
#include "synth/synth.h"

namespace covis {

class TestFrames {
 public:
  // The one there is for this sensor: making the world is dear.
  static TestFrames& of(Sensor sensor) {
    static TestFrames mono(Sensor::monocular), rgbd(Sensor::rgbd);
    return sensor == Sensor::rgbd ? rgbd : mono;
  }

  explicit TestFrames(Sensor sensor) : synth_(make(sensor)), frontend_(synth_.camera(), {}, sensor) {}

  FeaturesPtr features(int i) {
    const auto known = features_.find(i);
    if (known != features_.end()) return known->second;
    ImageU8 image;
    ImageF depth;
    synth_.render(i, image, nullptr, synth_.sensor() == Sensor::rgbd ? &depth : nullptr);
    const FeaturesPtr made =
        depth.empty() ? frontend_.monocular(image.view()) : frontend_.rgbd(image.view(), depth.view());
    return features_[i] = made;
  }
  // The same frame in another place: seen from the same poses, and like none of the desk's.
  FeaturesPtr elsewhere(int i) {
    auto other = std::make_shared<Features>(*features(i));
    for (Descriptor& d : other->descriptor) {
      for (uint64_t& bits : d.bits) bits ^= 0x5a3c96e1d2b4870fu;
    }
    return other;
  }
  // A frame without anything to see.
  FeaturesPtr blank() {
    ImageU8 image(synth_.camera().width, synth_.camera().height);
    ImageF depth(image.width(), image.height());
    for (int y = 0; y < image.height(); ++y) {
      std::fill(image.row(y), image.row(y) + image.width(), uint8_t{90});
      std::fill(depth.row(y), depth.row(y) + depth.width(), 2.0f);
    }
    return synth_.sensor() == Sensor::rgbd ? frontend_.rgbd(image.view(), depth.view())
                                           : frontend_.monocular(image.view());
  }
  const Pinhole& camera() const { return synth_.camera().pinhole; }
  // World: the camera of frame 0.
  SE3 T_cw(int i) const { return synth_.T_wc(i).inverse() * synth_.T_wc(0); }
  Timestamp stamp(int i) const { return synth_.stamp(i); }
  int count() const { return synth_.frames(); }

 private:
  static Synth make(Sensor sensor) {
    SynthOptions options;
    options.world = "desk";
    options.sensor = sensor == Sensor::rgbd ? "rgbd" : "mono";
    options.frames = 30;
    options.fps = 8;
    options.width = 320;
    options.height = 240;
    return std::move(Synth::create(options).value());
  }

  Synth synth_;
  Frontend frontend_;
  std::map<int, FeaturesPtr> features_;
};

// For each feature of a frame with a known pose the map point of `from` that lies there, if any. Every `keep`-th alone.
inline std::vector<MapPointId> points_seen(const Map& map, KeyFrameId from, const Features& features, const SE3& T_cw,
                                           int keep = 1) {
  const Pinhole& camera = map.camera();
  std::vector<MapPointId> seen(static_cast<size_t>(features.size()));
  int n = 0;
  for (const MapPointId id : map.at(from).points) {
    if (!id.valid() || n++ % keep != 0) continue;
    const Eigen::Vector3d p = T_cw * map.at(id).position_w;
    if (p.z() < 0.1) continue;
    const auto u = static_cast<float>(camera.fx * p.x() / p.z() + camera.cx);
    const auto v = static_cast<float>(camera.fy * p.y() / p.z() + camera.cy);
    int best = kHammingLow, best_feature = -1;
    for (size_t i = 0; i < seen.size(); ++i) {
      if (std::abs(features.x[i] - u) > 2 || std::abs(features.y[i] - v) > 2 || seen[i].valid()) continue;
      const int distance = hamming(map.at(id).descriptor, features.descriptor[i]);
      if (distance < best) best = distance, best_feature = static_cast<int>(i);
    }
    if (best_feature >= 0) seen[static_cast<size_t>(best_feature)] = id;
  }
  return seen;
}

inline std::vector<uint32_t> features_with_depth(const Features& features) {
  std::vector<uint32_t> all;
  for (int i = 0; i < features.size(); ++i) {
    if (features.has_depth(i)) all.push_back(static_cast<uint32_t>(i));
  }
  return all;
}

}  // namespace covis
