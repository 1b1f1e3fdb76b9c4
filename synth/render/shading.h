// SPDX-License-Identifier: Apache-2.0
// The inner loops, in SIMD (Highway, chosen at run time; every target gives the same bits, for none
// fuses multiplications with additions): filling the z-buffer, looking up
// textures where rays meet a plane, and motion blur.
#pragma once

#include <cstdint>

#include "covis/core/image.h"
#include "synth/render/texture.h"

namespace covis::synth {

// A flat surface in a frame. 1 / z, u / z and v / z are linear in the ray (x, y, 1).
struct Surface {
  float w_x, w_y, w_1;
  float u_x, u_y, u_1;
  float v_x, v_y, v_1;
  float w_min, w_max;  // 1 / z over the surface
  TextureView texture, detail;
  float gain;
  float detail_strength;     // relative change of tone by a step of one tone in the detail
  float detail_u, detail_v;  // detail repeats in one repeat of the texture
};

// Shading and means read these many elements after the last and write, in the output, numbers of no meaning there.
inline constexpr int kShadeOverrun = 15;

// Tones of `count` points: `x`, `y` are their rays, `scale` times pixel_x, pixel_y the size of their pixels in ray
// units.
void shade_surface(const Surface& surface, float pixel_x, float pixel_y, const float* x, const float* y,
                   const float* scale, int count, float* tone);

// Puts 1 / z = w_0 + i w_x where it is greater than z[i] there and `number` into id[i], for i below count.
void fill_span(float w_0, float w_x, uint32_t number, int count, float* z, uint32_t* id);

// For x below `count`: the mean of `steps[x]` bilinear look-ups in `image`, (step_x[x], step_y[x]) pixels apart, around
// pixel (x, y). Look-ups outside the image take its edge.
void mean_along_steps(ImageView<const float> image, int y, const float* step_x, const float* step_y, const float* steps,
                      int count, float* mean);

}  // namespace covis::synth
