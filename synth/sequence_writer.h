// SPDX-License-Identifier: Apache-2.0
// Writes a synthetic recording in a layout that the readers know: TUM RGB-D for RGB-D, KITTI odometry for stereo, an
// image folder with times for monocular; each with its ground truth.
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

// The treatment of a folder that is not empty.
enum class Existing { refuse, replace };

// Renders all frames of `synth` into `folder`, which is created if needed. A folder that is not empty is refused or, to
// be replaced, cleared of the files of an earlier recording of any kind. `progress` receives the number of frames done
// and may be empty; when it returns false, writing ends with an error. Images are encoded and written in a second
// thread.
Result<SynthReport> write_sequence(Synth& synth, const std::filesystem::path& folder, Existing existing,
                                   const std::function<bool(int)>& progress);

}  // namespace covis
