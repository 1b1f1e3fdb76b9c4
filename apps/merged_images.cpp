// SPDX-License-Identifier: Apache-2.0
#include "merged_images.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "covis/core/log.h"

namespace covis::app {

Result<size_t> keep_merged_images(const std::vector<std::string>& files, const MergeReport& report, const Map& merged,
                                  const exchange::KeptImages& kept) {
  std::vector<std::optional<exchange::KeptImages>> of_files;
  for (const std::string& file : files) {
    auto read = exchange::KeptImages::read(exchange::image_folder(file));
    if (!read) log(LogLevel::warning, read.error().message);
    of_files.push_back(read ? std::optional(std::move(*read)) : std::nullopt);
  }
  exchange::KeptImages images = kept.none();
  size_t count = 0, input = 0;
  for (const KeyFrameId& id : merged.key_frames()) {  // by rising serial, and so file by file
    const KeyFrame& key_frame = merged.at(id);
    while (input + 1 < files.size() && key_frame.serial >= report.inputs[input + 1].first_serial) ++input;
    if (!of_files[input]) continue;
    const auto from = of_files[input]->find(key_frame.serial - report.inputs[input].first_serial, key_frame.stamp);
    if (from.empty()) continue;
    const std::string name = exchange::image_stem(key_frame.serial) + from.extension().string();
    if (const auto copied = exchange::copy_image(from, images.folder() / name); !copied) {
      log(LogLevel::warning, copied.error().message);
      continue;
    }
    images.add(name, key_frame.stamp);
    ++count;
  }
  if (auto listed = images.write_list(kept); !listed) return tl::unexpected(listed.error());
  return count;
}

}  // namespace covis::app
