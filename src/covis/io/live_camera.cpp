// SPDX-License-Identifier: Apache-2.0
#include "covis/io/live_camera.h"

#include <algorithm>
#include <exception>
#include <string_view>
#include <utility>

#include "covis/core/failure_reason.h"

namespace covis::io {
namespace {

using Trouble = NewestFrame::Trouble;

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

LiveCamera::LiveCamera(std::unique_ptr<CameraDevice> device, Setup setup)
    : device_(std::move(device)), setup_(std::move(setup)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

std::string LiveCamera::description() const {
  return "camera " + setup_.name + ", " + size_text(setup_.camera.width, setup_.camera.height) + ", " +
         std::to_string(setup_.rate) + " Hz";
}

Result<std::optional<Frame>> LiveCamera::next(Frame recycled) {
  const bool all_taken = setup_.options.count >= 0 && taken_ >= setup_.options.count;
  if (all_taken || status_.state == LiveStatus::State::failed) return std::optional<Frame>();
  NewestFrame::Taken taken = newest_.take(std::move(recycled), setup_.options.stop);
  status_.dropped = taken.dropped;
  if (taken.trouble) {
    const auto& [trouble, error] = *taken.trouble;
    if (trouble == Trouble::gone) {
      status_.state = LiveStatus::State::gone;
    } else if (trouble == Trouble::failed) {
      status_.state = LiveStatus::State::failed;
    }
    return tl::unexpected(error);
  }
  if (taken.frame) {
    status_.state = LiveStatus::State::there;
    ++taken_;
  }
  return std::move(taken.frame);
}

Result<Picture> LiveCamera::picture(int64_t) { return fail(setup_.name + ": a camera's frames can't be read again"); }

void LiveCamera::run(const std::stop_token& stop) {
  constexpr size_t kLongest = 200;  // text of a thrown error
  Error failure{"camera " + setup_.name + ": its images are given up: "};
  failure.message.reserve(failure.message.size() + kLongest);  // so that a lack of memory can be reported
  try {
    while (capture(stop) && reopen(stop)) {
    }
  } catch (const std::exception& error) {
    failure.message.append(reason_of(error).substr(0, kLongest));
    newest_.report(Trouble::failed, std::move(failure));
  }
}

// Returns true when the camera is gone.
bool LiveCamera::capture(const std::stop_token& stop) {
  bool there = false;  // a camera that opens and gives no image is still the one that is gone
  while (!stop.stop_requested()) {
    const Result<Timestamp> grabbed = device_->grab();
    const int64_t index = captured_++;
    if (!grabbed) {
      if (!there && index > 0) return true;
      newest_.report(Trouble::gone, {"camera " + setup_.name + ": it is gone (" + grabbed.error().message +
                                     "); the map stays, and it is opened again as soon as it is back"});
      return true;
    }
    there = true;
    if (!wanted(index)) continue;
    Frame frame = newest_.memory();
    if (const auto decoded = device_->retrieve(frame.image); !decoded) {
      newest_.report(Trouble::unreadable,
                     {"camera " + setup_.name + ": frame " + std::to_string(index) + ": " + decoded.error().message});
      continue;
    }
    const Camera& camera = setup_.camera;
    if (frame.image.width() != camera.width || frame.image.height() != camera.height) {
      newest_.report(Trouble::failed, another_size(index, frame.image.width(), frame.image.height()));
      return false;
    }
    frame.index = index;
    frame.stamp = last_stamp_ = std::max(*grabbed, last_stamp_ + 1);
    newest_.put(std::move(frame));
  }
  return false;
}

// Returns true when the camera is open again.
bool LiveCamera::reopen(const std::stop_token& stop) {
  device_->close();
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      stopped_.wait_for(lock, stop, setup_.retry, [] { return false; });
    }
    if (stop.stop_requested()) return false;
    if (const auto format = device_->open()) {
      const bool known = format->width > 0 && format->height > 0;
      if (!known || (format->width == setup_.camera.width && format->height == setup_.camera.height)) return true;
      newest_.report(Trouble::failed, another_size(captured_, format->width, format->height));
      return false;
    }
  }
}

bool LiveCamera::wanted(int64_t index) const {
  const int64_t first = setup_.options.first;
  return index >= first && (index - first) % setup_.options.stride == 0;
}

Error LiveCamera::another_size(int64_t index, int width, int height) const {
  return {"camera " + setup_.name + ": frame " + std::to_string(index) + " is " + size_text(width, height) +
          ", and those before it " + size_text(setup_.camera.width, setup_.camera.height) +
          "; the size must stay that of the camera file"};
}

}  // namespace covis::io
