// SPDX-License-Identifier: Apache-2.0
// The kinds of Sequence: files in a folder or bag, a video file, and a live camera.
#pragma once

#include "covis/io/recording.h"
#include "covis/io/sequence.h"

namespace covis::io {

Result<std::unique_ptr<Sequence>> open_folder(Recording recording, const SequenceOptions& options);
Result<std::unique_ptr<Sequence>> open_video(const std::string& path, const Request& request,
                                             const SequenceOptions& options);
// path: the camera's number.
Result<std::unique_ptr<Sequence>> open_camera(const std::string& path, const Request& request,
                                              const SequenceOptions& options);

}  // namespace covis::io
