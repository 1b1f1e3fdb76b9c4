// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap_import.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "covis/core/log.h"
#include "covis/io/images.h"
#include "covis/map/map_edit.h"
#include "covis/mapping/point_creation.h"
#include "covis/mapping/point_fusion.h"

namespace covis::exchange {
namespace {

// An image of the model, and how many points it shares with another one.
struct Partner {
  size_t image = 0, points = 0;
};

// Far more than any track of a reconstruction; it keeps the walk over partners linear in the size of the model.
constexpr size_t kMaxImagesOfPoint = 1000;

// For each image those that share at least kCovisibilityThreshold points with it, the ones with most first. Error: the
// points are seen by too many images, on average of all sights.
Result<std::vector<std::vector<Partner>>> partners_of(const ColmapModel& model) {
  std::unordered_map<int64_t, std::vector<size_t>> images;  // by point
  size_t sights = 0, meetings = 0;
  for (size_t i = 0; i < model.images.size(); ++i) {
    for (const int64_t point : model.images[i].points) {
      std::vector<size_t>& seen = images[point];
      seen.push_back(i);
      ++sights;
      meetings += 2 * seen.size() - 1;  // the square of their number, in the end
    }
  }
  if (meetings > kMaxImagesOfPoint * sights) {
    return fail("the model: its points are seen by " + std::to_string(meetings / sights) +
                " images on average, more than " + std::to_string(kMaxImagesOfPoint));
  }
  std::vector<std::vector<Partner>> partners(model.images.size());
  std::vector<size_t> counts(model.images.size()), met;
  for (size_t i = 0; i < model.images.size(); ++i) {
    met.clear();
    for (const int64_t point : model.images[i].points) {
      for (const size_t other : images.at(point)) {
        if (counts[other]++ == 0) met.push_back(other);
      }
    }
    std::sort(met.begin(), met.end());
    for (const size_t other : met) {
      if (other != i && counts[other] >= static_cast<size_t>(kCovisibilityThreshold))
        partners[i].push_back({other, counts[other]});
      counts[other] = 0;
    }
    std::stable_sort(partners[i].begin(), partners[i].end(),
                     [](const Partner& a, const Partner& b) { return a.points > b.points; });
  }
  return partners;
}

class Importer {
 public:
  Importer(const ColmapModel& model, const OrbOptions& options, SharedMap& map)
      : model_(model),
        frontend_(model.camera, options, Sensor::monocular),
        map_(map),
        key_frames_(model.images.size()) {
    map_.write()->set_camera(model.camera.pinhole);
    reader_.leave_unturned();  // COLMAP takes images as they are stored
  }

  // False: the map is begun, and none of the image's partners is in it yet.
  Result<bool> add(const std::filesystem::path& file, size_t image, const std::vector<Partner>& partners) {
    std::vector<KeyFrameId> others;
    for (const Partner& partner : partners) {
      if (key_frames_[partner.image].valid() && others.size() < static_cast<size_t>(options_.create_neighbours_mono))
        others.push_back(key_frames_[partner.image]);
    }
    if (count_ > 0 && others.empty()) return false;
    if (auto read = reader_.grey(file, grey_); !read) return tl::unexpected(read.error());
    const Camera& camera = model_.camera;
    if (grey_.width() != camera.width || grey_.height() != camera.height) {
      return fail(file.string() + ": the image is " + std::to_string(grey_.width()) + "x" +
                  std::to_string(grey_.height()) + ", the model's camera " + std::to_string(camera.width) + "x" +
                  std::to_string(camera.height));
    }
    const FeaturesPtr features = frontend_.monocular(grey_.view())->for_key_frame();
    const KeyFrameId id = key_frames_[image] = map_.write()->add_key_frame(
        static_cast<int64_t>(image), from_seconds(static_cast<double>(image)), model_.images[image].T_cw, features);
    ++count_;
    if (others.empty()) return true;
    triangulate(id, others);
    map_.write()->attach_to_tree(id);
    fuse_neighbours(map_, id, Sensor::monocular, options_, fuser_);
    return true;
  }

  size_t count() const { return count_; }

 private:
  void triangulate(KeyFrameId id, const std::vector<KeyFrameId>& others) {
    PointTriangulation triangulation(model_.camera.pinhole, Sensor::monocular, KeyFrameView(*map_.read(), id));
    for (const KeyFrameId& other : others) triangulation.add(KeyFrameView(*map_.read(), other));
    MapEdit map(map_);
    for (const TriangulatedPoint& made : triangulation.made()) {
      const MapPointId point = map.add_point(made.position_w, id, made.feature);
      if (point.valid()) map.add_observation(point, made.neighbour, made.neighbour_feature);
    }
  }

  const ColmapModel& model_;
  Frontend frontend_;
  io::ImageReader reader_;
  ImageU8 grey_;
  SharedMap& map_;
  const MapperOptions options_;
  PointFuser fuser_;
  std::vector<KeyFrameId> key_frames_;  // of each image of the model; invalid: it is not in the map
  size_t count_ = 0;
};

}  // namespace

Result<void> import_colmap(const ColmapModel& model, const std::filesystem::path& images, const OrbOptions& options,
                           SharedMap& map) {
  const auto found = partners_of(model);
  if (!found) return tl::unexpected(found.error());
  const std::vector<std::vector<Partner>>& partners = *found;
  Importer importer(model, options, map);
  // The image with most partners begins the map.
  std::vector<size_t> waiting(model.images.size());
  std::iota(waiting.begin(), waiting.end(), size_t{0});
  std::stable_sort(waiting.begin(), waiting.end(),
                   [&](size_t a, size_t b) { return partners[a].size() > partners[b].size(); });
  for (size_t before = 0; before != waiting.size();) {
    before = waiting.size();
    std::erase_if(waiting, [&](size_t image) {
      const auto added = importer.add(images / model.images[image].name, image, partners[image]);
      if (!added) log(LogLevel::warning, added.error().message);
      return !added || *added;
    });
  }
  for (const size_t image : waiting) {
    log(LogLevel::warning,
        model.images[image].name + ": the image is left out: it shares too few points with the others");
  }
  if (importer.count() < 2) return fail(images.string() + ": fewer than two of the model's images could be used");
  if (map.read()->point_count() == 0)
    return fail(images.string() +
                ": no point could be triangulated: the images do not fit the model's poses and camera");
  return {};
}

}  // namespace covis::exchange
