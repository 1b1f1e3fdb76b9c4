// SPDX-License-Identifier: Apache-2.0
// A recording without calibration: its camera is found from its frames, and written as a camera file.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>

#include "apps/run/run_record.h"
#include "covis/core/error.h"
#include "covis/io/sequence.h"
#include "covis/slam/options.h"

namespace covis::app {

// True for a sequence that was opened uncalibrated and has no calibration.
inline bool lacks_calibration(const io::Sequence& sequence) { return sequence.camera().pinhole.fx == 0; }

// Plays the recording `path` several times to find its camera (camera_search.h), and writes that to camera.yaml in the
// folder `out`. Says what it does, unless `quiet`. An error where the recording does not tell the camera, or the file
// can't be written, and when interrupted.
Result<CameraEstimate> find_camera_of(const std::string& path, const io::SequenceOptions& reading,
                                      const SystemOptions& options, const std::filesystem::path& out, bool quiet,
                                      const std::atomic<int>& interrupt);

}  // namespace covis::app
