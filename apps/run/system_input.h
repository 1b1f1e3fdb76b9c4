// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "covis/io/sequence.h"
#include "covis/slam/system.h"

namespace covis::app {

// Returns views of the frame's images.
inline System::Input input_of(const io::Frame& frame) {
  return {.frame = frame.index,
          .stamp = frame.stamp,
          .image = frame.image.view(),
          .right = frame.right.view(),
          .depth = frame.depth.view()};
}

}  // namespace covis::app
