// SPDX-License-Identifier: Apache-2.0
// The folder with the key frames' images that `covis run --keep-images` leaves beside a saved map. Each image is named
// by its key frame's serial. A list beside them, images.txt, names each with its key frame's stamp, so that images of
// another map are not taken for those of this one, and nothing is removed that was not written here.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/time.h"

namespace covis::exchange {

// FILE.images.
std::filesystem::path image_folder(const std::filesystem::path& map_file);
// The name of a key frame's image without its ending: the serial in six digits or more.
std::string image_stem(uint32_t serial);
// Writes the bytes of one file to another, whole or not at all. Nothing is done where both are one.
Result<void> copy_image(const std::filesystem::path& from, const std::filesystem::path& to);

class KeptImages {
 public:
  // Error: no such folder. A folder without a list, which someone put together by hand, is taken by its names alone
  // (check_names()).
  static Result<KeptImages> read(const std::filesystem::path& folder);
  // Makes the folder, or takes one that was made so. Error: there is a folder with other things in it, or it can't be
  // made.
  static Result<KeptImages> open_to_write(const std::filesystem::path& folder);

  // The same folder without any image.
  KeptImages none() const { return KeptImages(folder_); }
  const std::filesystem::path& folder() const { return folder_; }
  // The file of a key frame's image; empty when there is none, or it is that of another map's key frame.
  std::filesystem::path find(uint32_t serial, Timestamp stamp) const;
  // Error: a folder without a list holds an image that is named after none of these key frames. The numbers of its
  // names will be those of frames then.
  Result<void> check_names(const std::vector<uint32_t>& serials) const;
  // Adds an image that lies in the folder.
  void add(const std::string& name, Timestamp stamp) { stamps_[name] = stamp; }
  // Writes the list, and removes the images that an earlier list named and this one does not.
  Result<void> write_list(const KeptImages& earlier) const;

 private:
  explicit KeptImages(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path folder_;
  bool listed_ = true;                       // false: without a list, any stamp will do
  std::map<std::string, Timestamp> stamps_;  // by the file's name
};

}  // namespace covis::exchange
