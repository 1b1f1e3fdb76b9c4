// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene_images.h"

#include <limits>
#include <string>
#include <vector>

#include "covis/exchange/kept_images.h"
#include "covis/features/rectification.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

// Where the images of a camera are taken from.
struct Undistortion {
  const Camera* given = nullptr;
  bool as_taken = false;  // they are copied
  ResamplingMap map;      // else: for each pixel of the wanted image the place in the image as it was taken
};

// A pixel of the undistorted image shows the same in both given.pinhole and refined: refining the focal length leaves
// pixels as they are.
Undistortion undistortion(const SceneCamera& camera) {
  const auto& [given, refined, wanted] = camera;
  if (given.distortion == Distortion::none && wanted == refined) return {&given, true, {}};
  Undistortion made{&given, false, ResamplingMap(given.width, given.height, given.width, given.height)};
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < given.height; ++v) {
    for (int u = 0; u < given.width; ++u) {
      const Eigen::Vector2d undistorted = refined.project(wanted.unproject(u, v));
      const auto at = given.project(given.pinhole.unproject(undistorted.x(), undistorted.y()));
      made.map.set(u, v, at ? static_cast<float>(at->x()) : kNowhere, at ? static_cast<float>(at->y()) : kNowhere);
    }
  }
  return made;
}

Result<void> resample(const fs::path& from, const Undistortion& way, const fs::path& to) {
  const Camera& given = *way.given;
  auto picture = io::read_picture(from);
  if (!picture) return tl::unexpected(picture.error());
  if (picture->width != given.width || picture->height != given.height) {
    return fail(from.string() + ": the image is " + std::to_string(picture->width) + "x" +
                std::to_string(picture->height) + ", the camera's that made the key frame " + std::to_string(given.width) + "x" +
                std::to_string(given.height));
  }
  const auto apply = [&](ImageView<const uint8_t> image, ImageU8& made) { way.map.apply(image, made); };
  return io::write_picture(to, io::resampled(*picture, apply));
}

}  // namespace

Result<size_t> write_images(const fs::path& folder_of_kept, const fs::path& folder, Scene& scene) {
  const auto kept = KeptImages::read(folder_of_kept);
  if (!kept) return tl::unexpected(kept.error());
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder can't be made: " + error.message());
  if (fs::equivalent(folder_of_kept, folder, error))
    return fail(folder.string() + ": the images would be written over those that they are made of");
  std::vector<Undistortion> ways;
  for (const SceneCamera& camera : scene.cameras) ways.push_back(undistortion(camera));
  size_t count = 0;
  for (SceneView& view : scene.views) {
    const fs::path from = kept->find(view.serial, view.stamp);
    view.image.clear();
    if (from.empty()) continue;
    const Undistortion& way = ways[view.camera];
    view.image = way.as_taken || from.extension() == ".jpg" ? from.filename().string() : image_name(view.serial);
    const auto written =
        way.as_taken ? copy_image(from, folder / view.image) : resample(from, way, folder / view.image);
    if (!written) return tl::unexpected(written.error());
    ++count;
  }
  return count;
}

}  // namespace covis::exchange
