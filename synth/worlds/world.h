// SPDX-License-Identifier: Apache-2.0
// The worlds: each builds its scene and the camera's path through it from a seed.
#pragma once

#include <cstdint>

#include "synth/render/camera_path.h"
#include "synth/render/scene.h"

namespace covis::synth {

// An RGB-D camera fit for a world.
struct DepthSensor {
  double baseline = 0.08;  // metres, a virtual one
  double units = 5000;     // a metre in its 16-bit images, which end at 65535 units
  double reach = 1;        // its range and its errors, in those of a Kinect
};

struct World {
  Scene scene;
  CameraPath path;
  double fps;       // frames a second
  int frames;       // once around the path and a little more, or to the end of an open one
  double baseline;  // metres, of a stereo camera fit for it
  DepthSensor depth_sensor{};
};

World make_room(uint64_t seed);
World make_corridor(uint64_t seed);
World make_street(uint64_t seed, double way = 0);  // way: about its length once around, metres; 0: some 310

World make_desk(uint64_t seed);
World make_twins(uint64_t seed);
World make_posters(uint64_t seed);

}  // namespace covis::synth
