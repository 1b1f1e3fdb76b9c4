// SPDX-License-Identifier: Apache-2.0
// The worlds: each builds its scene and the camera's path through it from a seed.
#pragma once

#include <cstdint>

#include "covis/synth/camera_path.h"
#include "covis/synth/scene.h"

namespace covis::synth {

struct World {
  Scene scene;
  CameraPath path;
  double fps;       // frames a second
  int frames;       // once around the path and a little more
  double baseline;  // metres, of a stereo camera fit for it
};

World make_room(uint64_t seed);
World make_corridor(uint64_t seed);
World make_street(uint64_t seed);
World make_desk(uint64_t seed);

}  // namespace covis::synth
