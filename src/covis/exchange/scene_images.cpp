// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene_images.h"

#include <limits>
#include <string>

#include "covis/exchange/kept_images.h"
#include "covis/features/rectification.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

// For each pixel of an image by the wanted camera the place in the image as it was taken. A pixel of the undistorted
// image shows the same in both given.pinhole and refined: refining the focal length leaves pixels as they are.
ResamplingMap resampling(const Camera& given, const Pinhole& refined, const Pinhole& wanted) {
  ResamplingMap map(given.width, given.height, given.width, given.height);
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < given.height; ++v) {
    for (int u = 0; u < given.width; ++u) {
      const Eigen::Vector2d undistorted = refined.project(wanted.unproject(u, v));
      const auto at = given.project(given.pinhole.unproject(undistorted.x(), undistorted.y()));
      map.set(u, v, at ? static_cast<float>(at->x()) : kNowhere, at ? static_cast<float>(at->y()) : kNowhere);
    }
  }
  return map;
}

Result<void> resample(const fs::path& from, const Camera& given, const ResamplingMap& map, const fs::path& to) {
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

Result<size_t> write_images(const fs::path& folder_of_kept, const Camera& given, const Pinhole& refined,
                            const fs::path& folder, Scene& scene) {
  const auto kept = KeptImages::read(folder_of_kept);
  if (!kept) return tl::unexpected(kept.error());
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder can't be made: " + error.message());
  if (fs::equivalent(folder_of_kept, folder, error))
    return fail(folder.string() + ": the images would be written over those that they are made of");
  const bool as_taken = given.distortion == Distortion::none && scene.camera == refined;
  const ResamplingMap map = as_taken ? ResamplingMap() : resampling(given, refined, scene.camera);
  size_t count = 0;
  for (SceneView& view : scene.views) {
    const fs::path from = kept->find(view.serial, view.stamp);
    view.image.clear();
    if (from.empty()) continue;
    view.image = as_taken || from.extension() == ".jpg" ? from.filename().string() : image_name(view.serial);
    const auto written =
        as_taken ? copy_image(from, folder / view.image) : resample(from, given, map, folder / view.image);
    if (!written) return tl::unexpected(written.error());
    ++count;
  }
  return count;
}

}  // namespace covis::exchange
