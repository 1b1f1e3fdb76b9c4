// SPDX-License-Identifier: Apache-2.0
// Renders a Scene: a z-buffer of polygon numbers at twice the resolution, filled in bands of rows, then shading. Pixels
// inside one polygon are shaded once, by an anisotropic trilinear look-up at the exact point the pixel's ray meets the
// plane; pixels at edges mix the polygons seen by their 3 x 3 samples (tent filter). Depth is exact: that of the
// polygon seen by the pixel's centre, from its plane. A lens with distortion is handled by the rays: visibility is
// looked up, sample by sample, in a larger pinhole z-buffer, and texture and depth are computed on the true ray of each
// pixel. Sources: Heckbert and Moreton, "Interpolation for polygon texture mapping and shading", 1991 (u/z, v/z, 1/z
// are linear in the image); McCormack et al., "Feline", SIGGRAPH 1999 (anisotropic look-ups by several isotropic ones
// along a line).
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"
#include "synth/render/scene.h"
#include "synth/render/shading.h"

namespace covis::synth {

class Renderer {
 public:
  // Fails when the lens cannot be inverted over the whole image.
  static Result<Renderer> create(const Camera& camera);

  // Tones 0 to 255 and z-depth in metres (0: sky, or nothing) of the scene as seen by the camera at T_wc.
  void render(const Scene& scene, const SE3& T_wc, ImageF& tone, ImageF& depth);

  // The ray (x / z, y / z) through pixel (x, y).
  Eigen::Vector2f ray(int x, int y) const {
    return {ray_x_[static_cast<size_t>(y * camera_.width + x)], ray_y_[static_cast<size_t>(y * camera_.width + x)]};
  }

  // Size of a pixel at the middle of the image in ray units, 1 / f.
  float pixel_size() const { return pixel_x_; }
  // A small step (of x / z and y / z) of the ray through pixel (x, y), in pixels.
  Eigen::Vector2f to_pixels(int x, int y, float ray_dx, float ray_dy) const;

 private:
  // A polygon in the frame, and its outline in z-buffer samples.
  struct Visible {
    Surface surface;
    bool sky;
    int first_edge, edges;
    int row_begin, row_end;
    double plane_x, plane_y, plane_1;  // 1 / z over samples
  };
  // A side of an outline, in samples.
  struct Edge {
    double slope, at;  // x = slope * y + at
    int kind;          // +1: lower bound of x, -1: upper bound, 0: bounds no x (level)
  };

  Renderer() = default;
  // d (x / z, y / z) / d pixel, at a pixel.
  Eigen::Matrix2f ray_jacobian(int x, int y) const;
  void collect(const Scene& scene, const SE3& T_wc);
  bool add_visible(const Scene& scene, const Polygon& polygon, const SE3& T_cw);
  bool add_outline(const Vector3d* points, int count, Visible& visible);
  void rasterise(int row_begin, int row_end);
  void shade_row(int y, const uint32_t* above, const uint32_t* middle, const uint32_t* below, float* tone,
                 float* depth);
  float depth_of(const Visible& visible, float x, float y) const;
  float shade_edge(const uint32_t* const (&rows)[3], int x, int y) const;

  Camera camera_;
  bool distorted_ = false;
  float pixel_x_ = 0, pixel_y_ = 0;                        // size of a pixel in ray units, 1 / f
  int columns_ = 0, rows_ = 0;                             // z-buffer samples
  double sample_scale_ = 2, origin_x_ = 0, origin_y_ = 0;  // sample = scale * f * ray + origin
  std::vector<float> ray_x_, ray_y_;                       // rays of the pixels
  std::vector<Eigen::Matrix2f> to_pixels_;                 // distorted: inverse of ray_jacobian() at each pixel
  std::vector<float> stretch_;      // size of each pixel in ray units, times f; without distortion a row of ones
  std::vector<int32_t> sample_of_;  // distorted: z-buffer row * columns + column of each of the image's own samples
  std::vector<int> band_row_begin_, band_row_end_;  // distorted: z-buffer rows each band needs

  std::vector<Visible> visible_;
  std::vector<Edge> edges_;
  std::vector<std::pair<float, int>> order_;  // nearest first
  std::vector<float> z_;                      // 1 / z of a band
  std::vector<uint32_t> id_, warped_;
  std::vector<uint8_t> uniform_;
};

}  // namespace covis::synth
