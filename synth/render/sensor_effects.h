// SPDX-License-Identifier: Apache-2.0
// Effects that a real camera adds to a perfect picture: an open shutter, changing exposure, noise, and a depth sensor's
// errors. Depth errors: Nguyen, Izadi, Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and
// tracking", 2012, eq. 4: sigma(z) = 0.0012 + 0.0019 (z - 0.4)^2 metres, none beyond the sensor's range or on surfaces
// seen edge-on.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/image.h"
#include "covis/core/random.h"
#include "covis/geometry/se3.h"
#include "synth/render/renderer.h"

namespace covis::synth {

// Relative brightness at a time: 1 with smooth changes of at most `amplitude`, by seed.
double exposure_gain(double amplitude, uint64_t seed, double seconds);

// Lays over each pixel what passes it while the shutter is open: the mean along the way that the point seen there moves
// in the image between T_begin and T_end (camera at opening and closing in the frame of the middle: T_middle_begin, …).
// `tone` is replaced; `scratch` is any image.
void blur_motion(const Renderer& renderer, const ImageF& depth, const SE3& T_middle_begin, const SE3& T_middle_end,
                 ImageF& tone, ImageF& scratch);

// Tones to bytes, with a gain and noise that grows with the light: variance = noise^2 (0.3 + 0.7 tone / 128).
void develop(const ImageF& tone, double gain, double noise, uint64_t seed, ImageU8& image);

// Makes exact depth that of a sensor whose range is `reach` times a Kinect's: noise of `strength` times the model,
// quantised to 1/units m, without what is nearer than 0.4 m (times reach), farther than 8 m, seen at a grazing angle or
// across an edge.
void disturb_depth(const Renderer& renderer, double strength, double reach, double units, uint64_t seed, ImageF& depth,
                   ImageF& scratch);

}  // namespace covis::synth
