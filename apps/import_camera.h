// SPDX-License-Identifier: Apache-2.0
// covis check --import-camera: a camera file out of that of another program.
#pragma once

#include <string>

namespace covis::app {

// Writes `out`, and for a stereo pair that is not rectified the two files beside it that a EuRoC sequence has. Returns
// the exit code.
int import_camera(const std::string& file, const std::string& out);

}  // namespace covis::app
