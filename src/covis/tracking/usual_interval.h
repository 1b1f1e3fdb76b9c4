// SPDX-License-Identifier: Apache-2.0
// The time between frames as it usually is. Frames that are stamped when they arrive come in bursts: some follow a few
// milliseconds after the one before, and the next is late by as much. A velocity since the frame before is then a
// frame's motion, or the noise of two poses, divided by next to nothing.
#pragma once

#include <array>
#include <cstddef>

#include "covis/core/time.h"

namespace covis {

class UsualInterval {
 public:
  // A frame came so long after the one before, or so long before the one behind it. True where that is much less than
  // usual: what moved meanwhile is to be taken together with the step before.
  bool is_burst(Timestamp elapsed);

 private:
  std::array<Timestamp, 8> last_{};  // a ring
  size_t count_ = 0;
};

}  // namespace covis
