// SPDX-License-Identifier: Apache-2.0
// A camera that is plugged in, as LiveCamera uses it. Tests are one themselves.
#pragma once

#include <memory>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/core/time.h"
#include "covis/io/camera_file.h"

namespace covis::io {

class CameraDevice {
 public:
  struct Format {
    int width = 0, height = 0;  // pixels; 0: the device does not say
    double fps = 0;             // 0: the device does not say
  };

  virtual ~CameraDevice() = default;
  // Opens the device, also again after close().
  virtual Result<Format> open() = 0;
  virtual void close() = 0;
  // Waits for the next image, no longer than a second or so, and returns when it came, by the steady clock. An error
  // means that the camera is gone.
  virtual Result<Timestamp> grab() = 0;
  // Decodes the image that was grabbed last to grey, in its own size.
  virtual Result<void> retrieve(ImageU8& grey) = 0;
};

}  // namespace covis::io
