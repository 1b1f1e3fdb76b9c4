// SPDX-License-Identifier: Apache-2.0
// For the tests of synth: small worlds, made once, and image measures.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "covis/core/quantile.h"
#include "synth/render/renderer.h"
#include "synth/synth.h"

namespace covis {

inline uint64_t hash(const ImageU8& image) {
  uint64_t h = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) h = (h ^ image(x, y)) * 0x100000001b3ull;
  }
  return h;
}

inline SynthOptions small(const std::string& world, const std::string& sensor = "rgbd") {
  SynthOptions options;
  options.world = world;
  options.sensor = sensor;
  options.width = 320;
  options.height = 240;
  return options;
}

inline Synth make(const SynthOptions& options) { return std::move(Synth::create(options).value()); }

// Making a world takes longer than rendering a frame of it, so worlds with default options are cached.
inline Synth& world(const std::string& name, int seed = 1) {
  static std::map<std::pair<std::string, int>, Synth> made;
  const auto at = made.find({name, seed});
  if (at != made.end()) return at->second;
  SynthOptions options = small(name);
  options.seed = seed;
  return made.emplace(std::pair(name, seed), make(options)).first->second;
}

template <class T>
double sample(const Image<T>& image, double x, double y) {
  const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
  const double fx = x - ix, fy = y - iy;
  const auto at = [&](int dx, int dy) { return static_cast<double>(image(ix + dx, iy + dy)); };
  return (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1 - fx) * at(0, 1) + fx * at(1, 1));
}

inline bool inside(const Camera& camera, const Eigen::Vector2d& p) {
  return p.x() >= 1 && p.y() >= 1 && p.x() < camera.width - 2 && p.y() < camera.height - 2;
}

}  // namespace covis
