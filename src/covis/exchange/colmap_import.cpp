// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap_import.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "covis/core/log.h"
#include "covis/io/images.h"
#include "covis/map/map_edit.h"
#include "covis/mapping/point_creation.h"
#include "covis/mapping/point_fusion.h"

namespace covis::exchange {
namespace {

struct Placed {
  const ColmapModel::Image* image;
  KeyFrameId key_frame;
};

size_t shared_points(const ColmapModel::Image& a, const ColmapModel::Image& b) {
  std::vector<int64_t> both;
  std::set_intersection(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), std::back_inserter(both));
  return both.size();
}

// The key frames whose images share most points with this one, best first.
std::vector<KeyFrameId> partners(const ColmapModel::Image& image, const std::vector<Placed>& placed, size_t most) {
  std::vector<std::pair<size_t, KeyFrameId>> found;
  for (const Placed& other : placed) {
    const size_t shared = shared_points(image, *other.image);
    if (shared >= static_cast<size_t>(kCovisibilityThreshold)) found.emplace_back(shared, other.key_frame);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<KeyFrameId> best;
  for (size_t i = 0; i < std::min(most, found.size()); ++i) best.push_back(found[i].second);
  return best;
}

class Importer {
 public:
  Importer(const ColmapModel& model, const OrbOptions& options, SharedMap& map)
      : camera_(model.camera), frontend_(model.camera, options, Sensor::monocular), map_(map) {
    map_.write()->set_camera(camera_.pinhole);
  }

  // False: it shares too few points with the images so far.
  Result<bool> add(const std::filesystem::path& file, const ColmapModel::Image& image, int64_t number) {
    const std::vector<KeyFrameId> others =
        partners(image, placed_, static_cast<size_t>(options_.create_neighbours_mono));
    if (!placed_.empty() && others.empty()) return false;
    if (auto read = reader_.grey(file, grey_); !read) return tl::unexpected(read.error());
    if (grey_.width() != camera_.width || grey_.height() != camera_.height) {
      return fail(file.string() + ": the image is " + std::to_string(grey_.width()) + "x" +
                  std::to_string(grey_.height()) + ", the model's camera " + std::to_string(camera_.width) + "x" +
                  std::to_string(camera_.height));
    }
    const FeaturesPtr features = frontend_.monocular(grey_.view())->for_key_frame();
    const KeyFrameId id =
        map_.write()->add_key_frame(number, from_seconds(static_cast<double>(number)), image.T_cw, features);
    placed_.push_back({&image, id});
    if (others.empty()) return true;
    triangulate(id, others);
    map_.write()->attach_to_tree(id);
    fuse_neighbours(map_, id, Sensor::monocular, options_, fuser_);
    return true;
  }

  size_t count() const { return placed_.size(); }

 private:
  void triangulate(KeyFrameId id, const std::vector<KeyFrameId>& others) {
    PointTriangulation triangulation(camera_.pinhole, Sensor::monocular, KeyFrameView(*map_.read(), id));
    for (const KeyFrameId& other : others) triangulation.add(KeyFrameView(*map_.read(), other));
    MapEdit map(map_);
    for (const TriangulatedPoint& made : triangulation.made()) {
      const MapPointId point = map.add_point(made.position_w, id, made.feature);
      if (point.valid()) map.add_observation(point, made.neighbour, made.neighbour_feature);
    }
  }

  const Camera camera_;
  Frontend frontend_;
  io::ImageReader reader_;
  ImageU8 grey_;
  SharedMap& map_;
  const MapperOptions options_;
  PointFuser fuser_;
  std::vector<Placed> placed_;
};

}  // namespace

Result<void> import_colmap(const ColmapModel& model, const std::filesystem::path& images, const OrbOptions& options,
                           SharedMap& map) {
  Importer importer(model, options, map);
  std::vector<const ColmapModel::Image*> waiting;
  for (const ColmapModel::Image& image : model.images) waiting.push_back(&image);
  for (size_t before = 0; before != waiting.size();) {
    before = waiting.size();
    std::erase_if(waiting, [&](const ColmapModel::Image* image) {
      const auto added = importer.add(images / image->name, *image, image - model.images.data());
      if (!added) log(LogLevel::warning, added.error().message);
      return !added || *added;
    });
  }
  for (const ColmapModel::Image* image : waiting)
    log(LogLevel::warning, image->name + ": the image is left out: it shares too few points with the others");
  if (importer.count() < 2) return fail(images.string() + ": fewer than two of the model's images could be used");
  return {};
}

}  // namespace covis::exchange
