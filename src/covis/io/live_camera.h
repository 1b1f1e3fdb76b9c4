// SPDX-License-Identifier: Apache-2.0
// A camera that is plugged in, as a sequence. A thread captures; next() gives the newest frame. A camera that goes away
// is opened again and again until it is back, while the one who takes the frames keeps the map.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "covis/io/camera_device.h"
#include "covis/io/newest_frame.h"
#include "covis/io/sequence.h"

namespace covis::io {

class LiveCamera : public Sequence {
 public:
  struct Setup {
    std::string name;  // for messages: the camera's number
    Camera camera;
    double rate = 30;                      // Hz
    SequenceOptions options;               // only first, count, stride and stop are used
    std::chrono::milliseconds retry{500};  // between two attempts to open a camera that is gone
  };

  // device: open.
  LiveCamera(std::unique_ptr<CameraDevice> device, Setup setup);

  SequenceKind kind() const override { return SequenceKind::camera; }
  Sensor sensor() const override { return Sensor::monocular; }
  const Camera& camera() const override { return setup_.camera; }
  int64_t size() const override { return -1; }
  double frame_rate() const override { return setup_.rate / static_cast<double>(setup_.options.stride); }
  std::optional<Truth> truth() const override { return std::nullopt; }
  std::string description() const override;
  std::vector<std::string> notes() const override { return {}; }
  Result<std::optional<Frame>> next(Frame recycled = {}) override;
  Result<Picture> picture(int64_t frame) override;
  bool may_have_colours(int64_t) const override { return false; }
  LiveStatus live() const override { return status_; }

 private:
  void run(const std::stop_token& stop);
  // Both return false where capturing is to end.
  bool capture(const std::stop_token& stop);
  bool reopen(const std::stop_token& stop);
  bool wanted(int64_t index) const;
  Error another_size(int64_t index, int width, int height) const;

  const std::unique_ptr<CameraDevice> device_;  // used by the thread
  const Setup setup_;
  NewestFrame newest_;
  LiveStatus status_;  // used by next() and live() only, as is taken_
  int64_t taken_ = 0;
  int64_t captured_ = 0;       // number of images grabbed, and of times that the camera went; used by the thread
  Timestamp last_stamp_ = -1;  // used by the thread
  std::mutex mutex_;           // for the wait between two attempts, which only a request to stop ends early
  std::condition_variable_any stopped_;
  std::jthread thread_;  // last member: it uses the others
};

}  // namespace covis::io
