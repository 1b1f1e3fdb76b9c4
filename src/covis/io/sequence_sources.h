// SPDX-License-Identifier: Apache-2.0
// The two kinds of Sequence: files in a folder, and a stream (video file or camera) from OpenCV.
#pragma once

#include "covis/io/recording.h"
#include "covis/io/sequence.h"

namespace covis::io {

Result<std::unique_ptr<Sequence>> open_folder(Recording recording, const SequenceOptions& options);
Result<std::unique_ptr<Sequence>> open_capture(const std::string& path, SequenceKind kind, const Request& request,
                                               const SequenceOptions& options);

}  // namespace covis::io
