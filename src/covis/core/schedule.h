// SPDX-License-Identifier: Apache-2.0
// When what mapping makes becomes visible to tracking (architecture.md, decision 6).
#pragma once

namespace covis {

enum class Schedule {
  deterministic,  // a fixed number of frames after the key frame: the result depends on input and settings alone
  realtime,       // as soon as it is ready, and mapping is interrupted by new key frames
};

}  // namespace covis
