// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene_images.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include "covis/core/atomic_file.h"
#include "covis/exchange/kept_images.h"
#include "covis/features/rectification.h"
#include "covis/io/files.h"
#include "covis/io/image_bytes.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

ResamplingMap undistortion(const SceneCamera& camera) {
  const auto& [given, refined, wanted] = camera;
  ResamplingMap map(given.width, given.height, given.width, given.height);
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < given.height; ++v) {
    for (int u = 0; u < given.width; ++u) {
      const auto at = image_pixel(given, refined, wanted.unproject(u, v));
      map.set(u, v, at ? static_cast<float>(at->x()) : kNowhere, at ? static_cast<float>(at->y()) : kNowhere);
    }
  }
  return map;
}

io::ExpectedSize size_by(const Camera& camera) { return {camera.width, camera.height, "its key frame"}; }

Result<std::string> copied(const fs::path& from, const Camera& camera) {
  std::string bytes;
  if (auto read = io::read_bytes(from, bytes); !read) return tl::unexpected(read.error());
  if (const auto problem = io::problem_of_image(bytes, size_by(camera))) return fail(from.string() + ": " + *problem);
  return bytes;
}

// `map` is made for the first image of a camera: that there is none must cost nothing.
Result<std::string> resampled(const fs::path& from, const SceneCamera& camera, std::optional<ResamplingMap>& map) {
  const Camera& given = camera.given;
  auto picture = io::read_picture(from, size_by(given));
  if (!picture) return tl::unexpected(picture.error());
  if (std::max(given.width, given.height) > ResamplingMap::kLargestSide)
    return fail(from.string() + ": images of more than " + std::to_string(ResamplingMap::kLargestSide) +
                " pixels a side can't be undistorted");
  if (!map) map = undistortion(camera);
  const auto apply = [&](ImageView<const uint8_t> image, ImageU8& made) { map->apply(image, made); };
  return io::picture_bytes(from, io::resampled(*picture, apply));
}

// True where the file is not there, or holds just these bytes.
Result<bool> is_free_for(const fs::path& file, const std::string& bytes) {
  std::error_code none;
  if (!fs::exists(file, none)) return true;
  std::string there;
  if (auto read = io::read_bytes(file, there); !read) return tl::unexpected(read.error());
  return there == bytes;
}

}  // namespace

Result<size_t> write_images(const fs::path& folder_of_kept, const fs::path& folder, Scene& scene, bool may_replace) {
  const auto kept = KeptImages::read(folder_of_kept);
  if (!kept) return tl::unexpected(kept.error());
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the folder can't be made: " + error.message());
  if (fs::equivalent(folder_of_kept, folder, error))
    return fail(folder.string() + ": the images would be written over those that they are made of");
  size_t count = 0;
  for (uint32_t k = 0; k < scene.cameras.size(); ++k) {
    const SceneCamera& camera = scene.cameras[k];
    const bool as_taken = camera.given.distortion == Distortion::none && !camera.refined.residual.any() &&
                          camera.pinhole == camera.refined;
    std::optional<ResamplingMap> map;
    for (SceneView& view : scene.views) {
      if (view.camera != k) continue;
      const fs::path from = kept->find(view.serial, view.stamp);
      view.image.clear();
      if (from.empty()) continue;
      view.image = as_taken || from.extension() == ".jpg" ? from.filename().string() : image_name(view.serial);
      const fs::path to = folder / view.image;
      const auto bytes = as_taken ? copied(from, camera.given) : resampled(from, camera, map);
      if (!bytes) return tl::unexpected(bytes.error());
      const auto is_free = may_replace ? Result<bool>(true) : is_free_for(to, *bytes);
      if (!is_free) return tl::unexpected(is_free.error());
      if (!*is_free)
        return fail(to.string() +
                    ": another image is there, which another model in this folder needs; remove that model or choose "
                    "another folder");
      if (auto written = write_atomically(to, *bytes); !written) return tl::unexpected(written.error());
      ++count;
    }
  }
  return count;
}

}  // namespace covis::exchange
