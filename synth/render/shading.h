// SPDX-License-Identifier: Apache-2.0
// The inner loops, in SIMD (Highway, chosen at run time): filling the z-buffer, looking up textures where rays meet a
// plane, and motion blur. All targets give bit-identical results because none fuses multiplications with additions.
#pragma once

#include <cstdint>

#include "covis/core/image.h"
#include "synth/render/texture.h"

namespace covis::synth {

// A flat surface in an image. 1 / z, u / z and v / z are linear in the ray (x, y, 1).
struct Surface {
  float w_x, w_y, w_1;
  float u_x, u_y, u_1;
  float v_x, v_y, v_1;
  float w_min, w_max;  // range of 1 / z over the surface
  TextureView texture, detail;
  float gain;
  float detail_strength;                                     // relative change of tone per tone step of the detail
  float detail_u, detail_v;                                  // number of detail repeats in one repeat of the texture
  TextureView light;                                         // texels are null: the light is as painted
  float light_u_scale, light_v_scale, light_u_0, light_v_0;  // from the texture's coordinates to those of the light
};

// The tone of a light map that leaves a surface as it is painted; twice that makes it twice as bright.
inline constexpr float kLightAsPainted = 110;

// Shading and means read up to this many elements past the end, and write as many meaningless output values.
inline constexpr int kShadeOverrun = 15;

// Computes the tones of `count` points. x, y: their rays; `scale` times pixel_x, pixel_y: the size of their pixels in
// ray units.
void shade_surface(const Surface& surface, float pixel_x, float pixel_y, const float* x, const float* y,
                   const float* scale, int count, float* tone);

// For each i below `count` with 1 / z = w_0 + i w_x greater than z[i], sets z[i] to it and id[i] to `number`.
void fill_span(float w_0, float w_x, uint32_t number, int count, float* z, uint32_t* id);

// For x below `count`: the mean of `steps[x]` bilinear look-ups in `image`, (step_x[x], step_y[x]) pixels apart, around
// pixel (x, y). Look-ups outside the image use its edge.
void mean_along_steps(ImageView<const float> image, int y, const float* step_x, const float* step_y, const float* steps,
                      int count, float* mean);

}  // namespace covis::synth
