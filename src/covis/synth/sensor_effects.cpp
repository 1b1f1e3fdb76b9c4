// SPDX-License-Identifier: Apache-2.0
#include "covis/synth/sensor_effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace covis::synth {
namespace {

constexpr float kFar = 1e4f;           // metres: as good as infinity for the way a pixel moves
constexpr int kMaxSteps = 24;          // look-ups along the way
constexpr size_t kNormals = 1u << 14;  // table of normal numbers

float bilinear(const ImageF& image, float x, float y) {
  x = std::clamp(x, 0.0f, static_cast<float>(image.width() - 1) - 0.001f);
  y = std::clamp(y, 0.0f, static_cast<float>(image.height() - 1) - 0.001f);
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const float *a = image.row(iy) + ix, *b = image.row(iy + 1) + ix;
  const float top = a[0] + fx * (a[1] - a[0]), bottom = b[0] + fx * (b[1] - b[0]);
  return top + fy * (bottom - top);
}

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
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float z = depth(x, y) > 0 ? depth(x, y) : kFar;
      const Eigen::Vector3f p(renderer.ray(x, y).x() * z, renderer.ray(x, y).y() * z, z);
      const Eigen::Vector3f b = R_b * p + t_b, e = R_e * p + t_e;
      float dx = 0, dy = 0;
      if (b.z() > 0.01f && e.z() > 0.01f) {
        const Eigen::Vector2f moved =
            renderer.to_pixels(x, y, e.x() / e.z() - b.x() / b.z(), e.y() / e.z() - b.y() / b.z());
        dx = moved.x();
        dy = moved.y();
      }
      const float length = std::sqrt(dx * dx + dy * dy);
      if (!(length > 0.3f)) {
        scratch(x, y) = tone(x, y);
        continue;
      }
      const int steps = std::min(kMaxSteps, static_cast<int>(length) + 2);
      float sum = 0;
      for (int i = 0; i < steps; ++i) {
        const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(steps) - 0.5f;
        sum += bilinear(tone, static_cast<float>(x) + t * dx, static_cast<float>(y) + t * dy);
      }
      scratch(x, y) = sum / static_cast<float>(steps);
    }
  }
  tone.swap(scratch);
}

Film::Film() {
  Random random(hash_seed(0x66696c6d, 1));
  for (size_t i = 0; i < kNormals; ++i) normals_.push_back(static_cast<float>(random.normal()));
  for (int tone = 0; tone < 256; ++tone) deviation_.push_back(static_cast<float>(std::sqrt(0.3 + 0.7 * tone / 128)));
}

void Film::develop(const ImageF& tone, double gain, double noise, uint64_t seed, ImageU8& image) {
  image.resize(tone.width(), tone.height());
  const float g = static_cast<float>(gain), n = static_cast<float>(noise);
  for (int y = 0; y < tone.height(); ++y) {
    const float* from = tone.row(y);
    uint8_t* to = image.row(y);
    if (noise <= 0) {
      for (int x = 0; x < tone.width(); ++x) to[x] = static_cast<uint8_t>(std::clamp(g * from[x] + 0.5f, 0.0f, 255.0f));
      continue;
    }
    Random random(hash_seed(seed, static_cast<uint64_t>(y)));
    for (int x = 0; x < tone.width(); ++x) {
      const float v = std::clamp(g * from[x], 0.0f, 255.0f);
      const float normal = normals_[random.next() >> 50];
      to[x] =
          static_cast<uint8_t>(std::clamp(v + n * deviation_[static_cast<size_t>(v)] * normal + 0.5f, 0.0f, 255.0f));
    }
  }
}

void disturb_depth(const Renderer& renderer, double strength, uint64_t seed, ImageF& depth, ImageF& scratch) {
  constexpr float kNearest = 0.4f, kFarthest = 8.0f, kSteepest = 6.0f;  // metres; tangent of the angle to the normal
  const int width = depth.width(), height = depth.height();
  scratch.resize(width, height);
  const float focal = 1 / renderer.pixel_size();
  for (int y = 0; y < height; ++y) {
    Random random(hash_seed(seed, static_cast<uint64_t>(y)));
    for (int x = 0; x < width; ++x) {
      const float z = depth(x, y);
      const double normal = random.normal(), luck = random.uniform();
      const int x0 = std::max(x - 1, 0), x1 = std::min(x + 1, width - 1), y0 = std::max(y - 1, 0),
                y1 = std::min(y + 1, height - 1);
      const float across = std::max(std::abs(depth(x1, y) - depth(x0, y)), std::abs(depth(x, y1) - depth(x, y0)));
      const bool steep = 0.5f * across * focal > kSteepest * z;
      if (!(z >= kNearest) || z > kFarthest || (steep && luck < 0.8)) {
        scratch(x, y) = 0;
        continue;
      }
      const double sigma = strength * (0.0012 + 0.0019 * (z - 0.4) * (z - 0.4));
      scratch(x, y) = static_cast<float>(std::round((z + sigma * normal) * 5000) / 5000);
    }
  }
  depth.swap(scratch);
}

}  // namespace covis::synth
