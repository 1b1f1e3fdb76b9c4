// SPDX-License-Identifier: Apache-2.0
#include "synth/render/sensor_effects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "synth/render/shading.h"

namespace covis::synth {
namespace {

constexpr float kLeastMotion = 0.3f;  // pixels; less is not seen
constexpr int kMaxSteps = 24;         // look-ups along the way
constexpr int kNormalShift = 50;      // shift of 64 random bits to an index into the table of normal numbers

// Normal numbers to draw from: quick, and many enough for noise.
const std::vector<float>& normal_table() {
  static const std::vector<float> table = [] {
    Random random(hash_seed(0x6e6f697365, 1));
    std::vector<float> values(size_t{1} << (64 - kNormalShift));
    for (float& value : values) value = static_cast<float>(random.normal());
    return values;
  }();
  return table;
}

uint8_t to_byte(float tone) { return static_cast<uint8_t>(std::min(std::max(tone + 0.5f, 0.0f), 255.0f)); }

}  // namespace

double exposure_gain(double amplitude, uint64_t seed, double seconds) {
  Random random(seed);
  double sum = 0, weight = 0;
  for (const double period : {31.0, 11.0, 4.3}) {
    const double w = std::sqrt(period);
    sum += w * std::sin(2 * std::numbers::pi * (seconds / (period * random.uniform(0.8, 1.2)) + random.uniform()));
    weight += w;
  }
  return 1 + amplitude * sum / weight;
}

void blur_motion(const Renderer& renderer, const ImageF& depth, const SE3& T_middle_begin, const SE3& T_middle_end,
                 ImageF& tone, ImageF& scratch) {
  const int width = tone.width(), height = tone.height();
  scratch.resize(width, height);
  const SE3 begin = T_middle_begin.inverse(), end = T_middle_end.inverse();
  const Eigen::Matrix3f R_b = begin.R().cast<float>(), R_e = end.R().cast<float>();
  const Eigen::Vector3f t_b = begin.t().cast<float>(), t_e = end.t().cast<float>();
  const size_t count = static_cast<size_t>(width + kShadeOverrun);
  std::vector<float> step_x(count), step_y(count), steps(count);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2f ray = renderer.ray(x, y);
      const Eigen::Vector3f r(ray.x(), ray.y(), 1);
      // Points are taken with z = 1 and the translations by 1 / z, so that the sky needs no case of its own.
      const float w = depth(x, y) > 0 ? 1 / depth(x, y) : 0;
      const Eigen::Vector3f b = R_b * r + w * t_b, e = R_e * r + w * t_e;
      Eigen::Vector2f moved(0, 0);
      if (b.z() > 0.01f && e.z() > 0.01f) {
        const float ib = 1 / b.z(), ie = 1 / e.z();
        moved = renderer.to_pixels(x, y, e.x() * ie - b.x() * ib, e.y() * ie - b.y() * ib);
      }
      const float length2 = moved.squaredNorm();
      const int n =
          length2 > kLeastMotion * kLeastMotion ? std::min(kMaxSteps, static_cast<int>(std::sqrt(length2)) + 2) : 1;
      const size_t i = static_cast<size_t>(x);
      steps[i] = static_cast<float>(n);
      step_x[i] = moved.x() / steps[i];
      step_y[i] = moved.y() / steps[i];
    }
    mean_along_steps(tone.view(), y, step_x.data(), step_y.data(), steps.data(), width, scratch.row(y));
  }
  tone.swap(scratch);
}

void develop(const ImageF& tone, double gain, double noise, uint64_t seed, ImageU8& image) {
  image.resize(tone.width(), tone.height());
  const float g = static_cast<float>(gain), n = static_cast<float>(noise);
  const std::vector<float>& normals = normal_table();
  std::array<float, 256> deviation;
  for (size_t t = 0; t < 256; ++t) deviation[t] = n * std::sqrt(0.3f + 0.7f * static_cast<float>(t) / 128);
  for (int y = 0; y < tone.height(); ++y) {
    const float* from = tone.row(y);
    uint8_t* to = image.row(y);
    if (noise <= 0) {
      for (int x = 0; x < tone.width(); ++x) to[x] = to_byte(g * from[x]);
      continue;
    }
    Random random(hash_seed(seed, static_cast<uint64_t>(y)));
    for (int x = 0; x < tone.width(); ++x) {
      const uint8_t v = to_byte(g * from[x]);
      to[x] = to_byte(g * from[x] + deviation[v] * normals[random.next() >> kNormalShift]);
    }
  }
}

void disturb_depth(const Renderer& renderer, double strength, double reach, double units, uint64_t seed, ImageF& depth,
                   ImageF& scratch) {
  constexpr float kNearest = 0.4f, kFarthest = 8.0f, kSteepest = 6.0f;  // metres; tangent of the angle to the normal
  constexpr uint64_t kLost = 205;                                       // pixels lost of 256 steep ones
  const float r = static_cast<float>(reach), quantum = static_cast<float>(units);
  const int width = depth.width(), height = depth.height();
  scratch.resize(width, height);
  const float half_focal = 0.5f / renderer.pixel_size(), s = static_cast<float>(strength * reach);
  const std::vector<float>& normals = normal_table();
  for (int y = 0; y < height; ++y) {
    Random random(hash_seed(seed, static_cast<uint64_t>(y)));
    const float *above = depth.row(std::max(y - 1, 0)), *row = depth.row(y),
                *below = depth.row(std::min(y + 1, height - 1));
    float* to = scratch.row(y);
    for (int x = 0; x < width; ++x) {
      const float z = row[x];
      const uint64_t bits = random.next();
      const float across =
          std::max(std::abs(row[std::min(x + 1, width - 1)] - row[std::max(x - 1, 0)]), std::abs(below[x] - above[x]));
      const bool steep = across * half_focal > kSteepest * z;
      const float k = z / r;  // as a Kinect would see it
      const float sigma = s * (0.0012f + 0.0019f * (k - 0.4f) * (k - 0.4f));
      const float sensed = std::floor((z + sigma * normals[bits >> kNormalShift]) * quantum + 0.5f) / quantum;
      to[x] = !(k >= kNearest) || k > kFarthest || (steep && (bits & 255) < kLost) ? 0 : sensed;
    }
  }
  depth.swap(scratch);
}

}  // namespace covis::synth
