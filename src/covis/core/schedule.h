// SPDX-License-Identifier: Apache-2.0
// The time at which the results of mapping become visible to tracking (architecture.md, decision 6).
#pragma once

namespace covis {

enum class Schedule {
  deterministic,  // a fixed number of frames after the key frame, so that the result depends only on input and settings
  realtime,       // as soon as they are ready; new key frames interrupt mapping
};

}  // namespace covis
