// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene_images.h"

#include <limits>
#include <map>
#include <string>

#include "covis/features/rectification.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

// For each pixel of the pinhole image the place in the image as it was taken.
ResamplingMap undistortion_of(const Camera& camera) {
  ResamplingMap map(camera.width, camera.height, camera.width, camera.height);
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto at = camera.project(camera.pinhole.unproject(u, v));
      map.set(u, v, at ? static_cast<float>(at->x()) : kNowhere, at ? static_cast<float>(at->y()) : kNowhere);
    }
  }
  return map;
}

// The files of a folder by their names without ending.
std::map<std::string, fs::path> files_by_stem(const fs::path& folder) {
  std::map<std::string, fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) files.emplace(entry.path().stem(), entry.path());
  return files;
}

Result<void> copy_image(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) return fail(to.string() + ": the image can't be written: " + error.message());
  return {};
}

Result<void> undistort(const fs::path& from, const Camera& given, const ResamplingMap& map, const fs::path& to) {
  auto picture = io::read_picture(from);
  if (!picture) return tl::unexpected(picture.error());
  if (picture->width != given.width || picture->height != given.height) {
    return fail(from.string() + ": the image is " + std::to_string(picture->width) + "x" +
                std::to_string(picture->height) + ", the map's camera " + std::to_string(given.width) + "x" +
                std::to_string(given.height));
  }
  const auto apply = [&](ImageView<const uint8_t> image, ImageU8& made) { map.apply(image, made); };
  return io::write_picture(to, io::resampled(*picture, apply));
}

}  // namespace

Result<size_t> write_images(const fs::path& kept, const Camera& given, const fs::path& folder, Scene& scene) {
  if (!fs::is_directory(kept))
    return fail(kept.string() + ": there is no folder of images; covis run --keep-images makes it");
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder can't be made: " + error.message());
  const std::map<std::string, fs::path> files = files_by_stem(kept);
  const bool distorted = given.distortion != Distortion::none;
  const ResamplingMap map = distorted ? undistortion_of(given) : ResamplingMap();
  size_t count = 0;
  for (SceneView& view : scene.views) {
    const std::string stem = fs::path(image_name(view.serial)).stem();
    const auto found = files.find(stem);
    view.image.clear();
    if (found == files.end()) continue;
    const fs::path& from = found->second;
    view.image = distorted && from.extension() != ".jpg" ? stem + ".png" : from.filename().string();
    const auto written =
        distorted ? undistort(from, given, map, folder / view.image) : copy_image(from, folder / view.image);
    if (!written) return tl::unexpected(written.error());
    ++count;
  }
  return count;
}

}  // namespace covis::exchange
