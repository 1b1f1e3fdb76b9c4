// SPDX-License-Identifier: Apache-2.0
#include "apps/run/key_frame_pictures.h"

#include <exception>
#include <optional>
#include <string>
#include <utility>

#include "covis/core/failure_reason.h"
#include "covis/core/log.h"
#include "covis/core/threads.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;

// Each returns the name of the file written; empty: there is none to be had.
Result<std::string> keep_own(io::Sequence& sequence, const KeyFrameState& key_frame, const fs::path& folder) {
  const auto picture = sequence.picture(key_frame.frame);
  if (!picture) return tl::unexpected(picture.error());
  const std::string ending = picture->file.empty() ? ".png" : picture->file.extension().string();
  const std::string name = exchange::image_stem(key_frame.serial) + ending;
  const auto written = picture->file.empty() ? io::write_picture(folder / name, *picture)
                                             : exchange::copy_image(picture->file, folder / name);
  if (!written) return tl::unexpected(written.error());
  return name;
}

Result<std::string> keep_earlier(const KeyFrameState& key_frame, const std::optional<exchange::KeptImages>& earlier,
                                 const fs::path& folder) {
  const fs::path image = earlier ? earlier->find(key_frame.serial, key_frame.stamp) : fs::path();
  if (image.empty()) return std::string();
  if (auto copied = exchange::copy_image(image, folder / image.filename()); !copied)
    return tl::unexpected(copied.error());
  return image.filename().string();
}

}  // namespace

KeyFrameColouring::KeyFrameColouring(io::Sequence& sequence, System& system) : sequence_(sequence), system_(system) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

KeyFrameColouring::~KeyFrameColouring() = default;

void KeyFrameColouring::wake() {
  const std::lock_guard lock(mutex_);
  woken_ = true;
  changed_.notify_one();
}

void KeyFrameColouring::finish() {
  thread_.request_stop();
  thread_.join();
  fill();
}

void KeyFrameColouring::run(const std::stop_token& stop) {
  lower_thread_priority();
  while (true) {
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return woken_; })) return;
      woken_ = false;
    }
    try {
      fill();
    } catch (const std::exception& error) {  // as a lack of memory: the map stays without their colours
      return log(LogLevel::warning, "key frames get no more colours: " + std::string(reason_of(error)));
    }
  }
}

void KeyFrameColouring::fill() {
  io::Picture picture;
  system_.colour_key_frames([&](int64_t frame) -> std::optional<ColourImage> {
    if (without_.contains(frame)) return std::nullopt;
    if (sequence_.may_have_colours(frame)) {
      auto read = sequence_.picture(frame);
      if (read && read->coloured()) {
        picture = std::move(*read);
        return picture.colours();
      }
    }
    without_.insert(frame);
    return std::nullopt;
  });
}

Result<void> keep_images(io::Sequence& sequence, const MapState& map, uint32_t first_own, const fs::path& earlier_map,
                         const exchange::KeptImages& before) {
  std::optional<exchange::KeptImages> earlier;
  if (const fs::path folder = exchange::image_folder(earlier_map); !earlier_map.empty() && fs::is_directory(folder)) {
    auto read = exchange::KeptImages::read(folder);
    if (!read) return tl::unexpected(read.error());
    earlier = std::move(*read);
  }
  exchange::KeptImages kept = before.none();
  size_t missing = 0;
  for (const KeyFrameState& key_frame : map.key_frames) {
    const bool own = key_frame.serial >= first_own;
    auto name = own ? keep_own(sequence, key_frame, kept.folder()) : keep_earlier(key_frame, earlier, kept.folder());
    if (!name) log(LogLevel::warning, "--keep-images: " + name.error().message);
    if (name && !name->empty()) {
      kept.add(*name, key_frame.stamp);
    } else {
      ++missing;
    }
  }
  if (missing > 0) {
    log(LogLevel::warning, "--keep-images: " + std::to_string(missing) + " of " +
                               std::to_string(map.key_frames.size()) + " key frames have no image");
  }
  return kept.write_list(before);
}

}  // namespace covis::app
