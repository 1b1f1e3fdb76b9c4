// SPDX-License-Identifier: Apache-2.0
// Finds the camera that a recording was made with from the recording alone: the focal length, two radial coefficients
// and the principal point. The recording's beginning is tracked with a few guesses of the focal length. The map of each
// is adjusted together with the lens (lens_adjustment.h). From the guess whose map fits best afterwards on it is
// tracked with less and with more, until the focal length that gives back itself is known (lens_answers.h). At last it
// is tracked twice close beside that with aligned matches and many key frames, which tell it more closely. What does
// not show is left out: no distortion, the principal point in the middle of the image. Pixels are square. The same
// frames give the same camera. Measured: docs/notes/039-a-camera-found.md.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/core/time.h"
#include "covis/geometry/camera.h"
#include "covis/optimization/lens_adjustment.h"
#include "covis/slam/options.h"

namespace covis {

// Takes the frames of a recording in their order, all of one size; returns false when it has seen enough.
using FrameVisitor = std::function<bool(ImageView<const uint8_t> image, Timestamp stamp)>;
// Plays the recording from its first frame to the visitor, the same each time.
using RecordingPlayer = std::function<Result<void>(const FrameVisitor& visit)>;

struct FoundCamera {
  Camera camera;          // has Brown's model with k1 and k2 where they show
  Lens sigma;             // standard deviations, also of what was left as usual
  size_t key_frames = 0;  // number of key frames of the map that shows it
};

// `width`, `height`: size of the images, pixels. `tell` gets what is done, a line each. An error when the frames or the
// motion do not tell the camera, and when interrupted.
Result<FoundCamera> find_camera(int width, int height, const RecordingPlayer& play, const SystemOptions& options,
                                const std::function<void(const std::string&)>& tell,
                                const std::atomic<int>* interrupt = nullptr);

}  // namespace covis
