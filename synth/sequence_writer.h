// SPDX-License-Identifier: Apache-2.0
// Writes a synthetic recording as the folders the readers know: TUM RGB-D layout for RGB-D, KITTI odometry layout for
// stereo, an image folder with times for monocular; each with its truth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "covis/core/error.h"
#include "synth/synth.h"

namespace covis {

struct SynthReport {
  int frames = 0;
  double path_metres = 0;
  uint64_t bytes = 0;  // size of all images
};

// The rule for a folder that holds something.
enum class Existing { refuse, replace };

// Renders all frames of `synth` into `folder`, which is made if need be. A folder that holds anything already is
// refused, or, to be replaced, cleared of what an earlier recording of any kind left there. `progress` receives the
// number of frames done and may be empty; when it returns false, writing ends with an error. Images are coded and
// written in a second thread.
Result<SynthReport> write_sequence(Synth& synth, const std::filesystem::path& folder, Existing existing,
                                   const std::function<bool(int)>& progress);

}  // namespace covis
