// SPDX-License-Identifier: Apache-2.0
// The path around a block: a rectangle with round corners, driven anticlockwise, slower in the corners.
#pragma once

#include <cstdint>

#include "synth/render/camera_path.h"

namespace covis::synth {

struct LoopOptions {
  double length = 0, width = 0;  // sides of the centre line's rectangle around the origin, metres along x and y
  double corner = 0;             // radius of the corners, metres
  double fast = 0, slow = 0;     // speed on the straights and in the corners, metres a second
  double easing = 0;             // metres over which the speed changes before and after a corner
  double height = 0;             // height of the camera, metres
  double pitch = 0;              // radians, upwards
  double weave = 0;              // greatest distance from the centre line, metres
  double glance = 0;             // greatest heading away from straight ahead, radians
  double start = 0;              // start of the path, metres along it from the middle of the side at -y
  Sway sway;
};

CameraPath make_loop(const LoopOptions& options, uint64_t seed);

}  // namespace covis::synth
