// SPDX-License-Identifier: Apache-2.0
// The worlds: each builds its scene, and the camera's path through it, from a seed.
#pragma once

#include <cstdint>

#include "synth/render/camera_path.h"
#include "synth/render/scene.h"

namespace covis::synth {

// An RGB-D camera suited to a world.
struct DepthSensor {
  double baseline = 0.08;  // virtual baseline, metres
  double units = 5000;     // units per metre in its 16-bit images, whose greatest value is 65535
  double reach = 1;        // its range and errors relative to a Kinect's
};

struct World {
  Scene scene;
  CameraPath path;
  double fps;       // frames per second
  int frames;       // a little more than one round, or up to the end of an open path
  double baseline;  // baseline of a suitable stereo camera, metres
  DepthSensor depth_sensor{};
};

World make_room(uint64_t seed);
World make_corridor(uint64_t seed);
World make_street(uint64_t seed, double way = 0);  // way: approximate length of a round, metres; 0: some 310

World make_desk(uint64_t seed);
World make_twins(uint64_t seed);
World make_posters(uint64_t seed);

}  // namespace covis::synth
