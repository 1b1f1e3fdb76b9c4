// SPDX-License-Identifier: Apache-2.0
// Frames of a recording in files, for faults to be put in.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "covis/io/sequence.h"
#include "tests/faults/fault_run.h"

namespace covis::faults {

class StoredRecording : public GoodRecording {
 public:
  // Reads the frames that the options choose, and their true positions, which the recording must have.
  static Result<StoredRecording> read(const std::filesystem::path& folder, const io::SequenceOptions& options);

  Sensor sensor() const override { return sensor_; }
  Camera camera() const override { return camera_; }
  int size() const override { return static_cast<int>(frames_.size()); }
  const Moment& operator()(int i) override;
  std::optional<Eigen::Vector3d> position(int i) const override { return positions_[static_cast<size_t>(i)]; }

 private:
  Sensor sensor_ = Sensor::monocular;
  Camera camera_;
  std::vector<Moment> frames_;
  std::vector<std::optional<Eigen::Vector3d>> positions_;
};

}  // namespace covis::faults
