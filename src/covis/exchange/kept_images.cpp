// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/kept_images.h"

#include <cstdio>
#include <cstdlib>
#include <set>
#include <sstream>
#include <utility>

#include "covis/core/atomic_file.h"
#include "covis/exchange/text.h"
#include "covis/io/files.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

constexpr const char* kList = "images.txt";
constexpr Timestamp kSame = 1000;  // nanoseconds: stamps that were seconds meanwhile

}  // namespace

fs::path image_folder(const fs::path& map_file) { return map_file.string() + ".images"; }

std::string image_stem(uint32_t serial) {
  char name[16];
  std::snprintf(name, sizeof name, "%06u", serial);
  return name;
}

Result<void> copy_image(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (fs::equivalent(from, to, error)) return {};
  std::string bytes;
  if (auto read = io::read_bytes(from, bytes); !read) return read;
  return write_atomically(to, bytes);
}

Result<KeptImages> KeptImages::read(const fs::path& folder) {
  if (!fs::is_directory(folder))
    return fail(folder.string() + ": there is no folder of images; covis run --keep-images makes it");
  KeptImages kept(folder);
  kept.listed_ = fs::exists(folder / kList);
  std::istringstream list;
  if (kept.listed_) {
    const auto text = io::read_text(folder / kList);
    if (!text) return tl::unexpected(text.error());
    list.str(*text);
  }
  std::string name;
  std::error_code error;
  for (Timestamp stamp = 0; list >> name >> stamp;) {
    // Names of this folder alone, and no links, which Covis does not make: they would lead to files of others.
    const fs::path file = folder / fs::path(name).filename();
    if (fs::is_regular_file(fs::symlink_status(file, error))) kept.stamps_[file.filename()] = stamp;
  }
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!kept.listed_ && io::is_image(entry.path())) kept.stamps_[entry.path().filename()] = 0;
  }
  return kept;
}

Result<KeptImages> KeptImages::open_to_write(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder for the key frames' images can't be made: " + error.message());
  auto kept = read(folder);
  if (kept && (!kept->listed_ && !fs::is_empty(folder, error)))
    return fail(folder.string() + ": --keep-images would write into this folder, which holds other things");
  return kept;
}

fs::path KeptImages::find(uint32_t serial, Timestamp stamp) const {
  const std::string stem = image_stem(serial);
  for (auto at = stamps_.lower_bound(stem); at != stamps_.end() && at->first.starts_with(stem); ++at) {
    if (fs::path(at->first).stem() == stem && (!listed_ || std::abs(at->second - stamp) < kSame))
      return folder_ / at->first;
  }
  return {};
}

Result<void> KeptImages::check_names(const std::vector<uint32_t>& serials) const {
  if (listed_) return {};
  std::set<std::string> stems;
  for (const uint32_t serial : serials) stems.insert(image_stem(serial));
  for (const auto& [name, stamp] : stamps_) {
    if (!stems.contains(fs::path(name).stem().string())) {
      return fail(
          (folder_ / name).string() +
          ": no key frame has this number, so the images here will be numbered otherwise, as frames are; without " +
          kList + ", which covis run --keep-images writes, each image must be named after its key frame's id");
    }
  }
  return {};
}

Result<void> KeptImages::write_list(const KeptImages& earlier) const {
  Text text;
  for (const auto& [name, stamp] : stamps_) text.line(name, stamp);
  if (auto written = write_atomically(folder_ / kList, text.take()); !written) return written;
  std::error_code error;
  for (const auto& [name, stamp] : earlier.stamps_) {
    if (!stamps_.contains(name)) fs::remove(earlier.folder_ / fs::path(name).filename(), error);
  }
  return {};
}

}  // namespace covis::exchange
