// SPDX-License-Identifier: Apache-2.0
// Faults of cameras and of the ways from them: what comes in place of a good frame.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "covis/core/image.h"
#include "covis/core/random.h"
#include "covis/core/sensor.h"
#include "covis/core/time.h"

namespace covis::faults {

struct Moment {
  ImageU8 left, right;
  ImageF depth;
  Timestamp stamp = 0;
};

Moment copy(const Moment& moment);

// Gives the good frame of a number; negative numbers give the first.
using GoodFrames = std::function<const Moment&(int)>;

struct Fault {
  std::string name;
  // Gives what comes in place of frame i; nullopt: nothing comes. Random numbers come from `random`, which is another
  // for each frame.
  std::function<std::optional<Moment>(int i, const GoodFrames& good, Random& random)> at;
};

// Depth, or the right image, that is nonsense: for a whole recording. None of a monocular camera.
std::vector<Fault> sensor_faults(Sensor sensor);
// Faults of a stream, for a while.
std::vector<Fault> stream_faults(Sensor sensor);

}  // namespace covis::faults
