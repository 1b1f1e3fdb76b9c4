// SPDX-License-Identifier: Apache-2.0
// The picture written by `covis check`: for stereo both images with horizontal lines and matched keypoints joined (a
// line must cross the same objects in both), for RGB-D the depth laid over the image (edges must coincide), for
// monocular the keypoints.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "covis/core/error.h"
#include "covis/core/sensor.h"
#include "covis/io/sequence.h"

namespace covis::app {

class CheckPicture {
 public:
  static constexpr int kFrames = 4;  // number of frames drawn, one below the other

  CheckPicture(const Camera& camera, Sensor sensor);
  ~CheckPicture();
  // Returns for a stereo pair the share of the left keypoints that have a match in the same row of the right image.
  std::optional<double> add(const io::Frame& frame);
  Result<void> write(const std::filesystem::path& file) const;
  std::string caption() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace covis::app
