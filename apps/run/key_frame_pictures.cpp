// SPDX-License-Identifier: Apache-2.0
#include "apps/run/key_frame_pictures.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <string>
#include <system_error>

#include "covis/core/log.h"
#include "covis/core/threads.h"
#include "covis/io/files.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;

std::string name_of_image(uint32_t serial) {
  char name[16];
  std::snprintf(name, sizeof name, "%06u", serial);
  return name;
}

// The image in a folder that has this name and any ending; empty: there is none.
fs::path image_named(const fs::path& folder, const std::string& name) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().stem() == name) return entry.path();
  }
  return {};
}

Result<void> copy_image(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (fs::equivalent(from, to, error)) return {};
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) return fail(to.string() + ": the image can't be written: " + error.message());
  return {};
}

bool is_image_of_a_key_frame(const fs::path& file) {
  const std::string stem = file.stem().string();
  return stem.size() >= 6 && stem.find_first_not_of("0123456789") == std::string::npos;
}

void remove_others(const fs::path& folder, const std::set<std::string>& kept) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!is_image_of_a_key_frame(entry.path()) || kept.contains(entry.path().filename().string())) continue;
    fs::remove(entry.path(), error);
  }
}

// Returns the name of the file written.
Result<std::string> keep_own(io::Sequence& sequence, const KeyFrameState& key_frame, const fs::path& folder) {
  const auto picture = sequence.picture(key_frame.frame);
  if (!picture) return tl::unexpected(picture.error());
  const std::string ending = picture->file.empty() ? ".png" : picture->file.extension().string();
  const std::string name = name_of_image(key_frame.serial) + ending;
  const auto written =
      picture->file.empty() ? io::write_picture(folder / name, *picture) : copy_image(picture->file, folder / name);
  if (!written) return tl::unexpected(written.error());
  return name;
}

Result<std::string> keep_earlier(const KeyFrameState& key_frame, const fs::path& earlier, const fs::path& folder) {
  const fs::path image = image_named(earlier, name_of_image(key_frame.serial));
  if (image.empty()) return std::string();  // it was not kept then
  if (const auto copied = copy_image(image, folder / image.filename()); !copied) return tl::unexpected(copied.error());
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
  while (!grey_) {
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return woken_; })) return;
      woken_ = false;
    }
    fill();
  }
}

void KeyFrameColouring::fill() {
  io::Picture picture;
  system_.colour_key_frames([&](int64_t frame) -> std::optional<ColourImage> {
    if (grey_) return std::nullopt;
    auto read = sequence_.picture(frame);
    if (!read) return std::nullopt;  // the run has said so, or a camera's frame is gone
    picture = std::move(*read);
    grey_ = !picture.coloured();
    if (grey_) return std::nullopt;
    return picture.colours();
  });
}

fs::path image_folder(const fs::path& map_file) { return map_file.string() + ".images"; }

Result<void> keep_images(io::Sequence& sequence, const MapState& map, uint32_t first_own, const fs::path& earlier,
                         const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder for the key frames' images can't be made: " + error.message());
  std::set<std::string> kept;
  for (const KeyFrameState& key_frame : map.key_frames) {
    const bool own = key_frame.serial >= first_own;
    auto name = own ? keep_own(sequence, key_frame, folder) : keep_earlier(key_frame, earlier, folder);
    if (name) {
      kept.insert(std::move(*name));
    } else {
      log(LogLevel::warning, "--keep-images: " + name.error().message);
    }
  }
  remove_others(folder, kept);
  return {};
}

}  // namespace covis::app
