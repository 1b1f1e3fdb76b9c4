// SPDX-License-Identifier: Apache-2.0
// For tests: a camera that gives the images that a test hands it, and goes and comes back when that says so. Nothing in
// it takes time: it waits for the test, and the test for it.
#pragma once

#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <new>
#include <optional>
#include <utility>

#include "covis/io/camera_device.h"

namespace covis::io {

class TestCamera {
 public:
  // Shown images are copied from `image`.
  struct Step {
    Timestamp stamp = 0;
    ImageView<const uint8_t> image;
    bool throws = false;  // a lack of memory, instead of giving the image
  };

  // A device that this camera stands behind; it must not outlive the camera.
  std::unique_ptr<CameraDevice> device() { return std::make_unique<Device>(*this); }

  ~TestCamera() { unplug_for_good(); }

  void show(Timestamp stamp, ImageView<const uint8_t> image) { add(Step{.stamp = stamp, .image = image}); }
  // Lacks memory for the next image.
  void lack_memory() { add(Step{.stamp = 0, .image = {}, .throws = true}); }
  // Goes away, and refuses to be opened `refusals` times; -1: for good.
  void go_away(int refusals) {
    {
      const std::lock_guard lock(mutex_);
      refusals_ = refusals;
    }
    add(std::nullopt);
  }
  void say_size(int width, int height) {
    const std::lock_guard lock(mutex_);
    format_ = {width, height, 30};
  }
  // Waits until the device was asked for an image `count` times: all images of the times before were handed on by then.
  void wait_until_asked(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return asked_ >= count; });
  }
  void wait_until_refused(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return refused_ >= count; });
  }
  // From now on no call waits. A test calls it before its LiveCamera ends, which waits for the call under way.
  void unplug_for_good() {
    const std::lock_guard lock(mutex_);
    over_ = true;
    changed_.notify_all();
  }

 private:
  class Device : public CameraDevice {
   public:
    explicit Device(TestCamera& camera) : camera_(camera) {}
    Result<Format> open() override { return camera_.open(); }
    void close() override {}
    Result<Timestamp> grab() override { return camera_.grab(); }
    Result<void> retrieve(ImageU8& grey) override { return camera_.retrieve(grey); }

   private:
    TestCamera& camera_;
  };

  void add(std::optional<Step> step) {
    const std::lock_guard lock(mutex_);
    steps_.push_back(step);
    changed_.notify_all();
  }

  Result<CameraDevice::Format> open() {
    const std::lock_guard lock(mutex_);
    if (refusals_ != 0) {
      refusals_ -= refusals_ > 0;
      ++refused_;
      changed_.notify_all();
      return fail("refused");
    }
    return format_;
  }

  Result<Timestamp> grab() {
    std::unique_lock lock(mutex_);
    ++asked_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return over_ || !steps_.empty(); });
    if (over_) return fail("unplugged");
    const std::optional<Step> step = steps_.front();
    steps_.pop_front();
    if (!step) return fail("unplugged");
    if (step->throws) throw std::bad_alloc();
    shown_ = step->image;
    return step->stamp;
  }

  Result<void> retrieve(ImageU8& grey) {
    if (!shown_.data) return fail("it can't be decoded");
    grey.resize(shown_.width, shown_.height);
    for (int y = 0; y < shown_.height; ++y)
      std::memcpy(grey.row(y), shown_.data + y * shown_.stride, static_cast<size_t>(shown_.width));
    return {};
  }

  std::mutex mutex_;  // guards all but shown_
  std::condition_variable changed_;
  std::deque<std::optional<Step>> steps_;  // nullopt: it goes away
  CameraDevice::Format format_;
  int refusals_ = 0, refused_ = 0, asked_ = 0;
  bool over_ = false;
  ImageView<const uint8_t> shown_;  // used by the thread that captures
};

}  // namespace covis::io
