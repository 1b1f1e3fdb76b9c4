// SPDX-License-Identifier: Apache-2.0
#include "covis/map/camera_change.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <unordered_set>

#include "covis/features/straightening.h"

namespace covis {
namespace {

constexpr float kMostPixels = 1e6f;  // from the origin, of a corner of an image

// From the pixels of one camera to those of another.
struct PixelChange {
  double ax, bx, ay, by;

  PixelChange(const Pinhole& from, const Pinhole& to)
      : ax(to.fx / from.fx), bx(to.cx - ax * from.cx), ay(to.fy / from.fy), by(to.cy - ay * from.cy) {}
  float x(float u) const { return static_cast<float>(ax * static_cast<double>(u) + bx); }
  float y(float v) const { return static_cast<float>(ay * static_cast<double>(v) + by); }
  double size() const { return std::sqrt(ax * ay); }
  // There and back again is 1.
  float base(float before) const {
    const auto after = static_cast<float>(static_cast<double>(before) * size());
    return std::abs(after - 1) < 1e-5f ? 1 : after;
  }
  ImageBounds operator()(const ImageBounds& b) const { return {x(b.min_x), y(b.min_y), x(b.max_x), y(b.max_y)}; }
};

using Pyramids = std::map<const ScalePyramid*, std::shared_ptr<const ScalePyramid>>;

std::shared_ptr<Features> changed(const Features& of, const PixelChange& change, double bf, Pyramids& pyramids,
                                  const std::shared_ptr<const Pinhole>& straightened_for,
                                  const std::shared_ptr<const ShiftField>& right_columns) {
  auto f = std::make_shared<Features>(of);
  f->straightened_for = straightened_for;
  f->right_columns = right_columns;
  f->patches = nullptr;  // their places are those of another camera
  f->kept_depth = nullptr;
  f->raw_x = of.image_x();  // they stay where they are in their image
  f->raw_y = of.image_y();
  for (size_t i = 0; i < of.x.size(); ++i) {
    f->x[i] = change.x(of.x[i]);
    f->y[i] = change.y(of.y[i]);
    f->u_right[i] = of.depth[i] > 0 ? f->x[i] - static_cast<float>(bf) / of.depth[i] : -1.0f;
  }
  std::shared_ptr<const ScalePyramid>& pyramid = pyramids[of.pyramid.get()];
  if (!pyramid) {
    const ScalePyramid& p = *of.pyramid;
    pyramid = std::make_shared<ScalePyramid>(p.levels, p.factor, change.base(p.base));
  }
  f->pyramid = pyramid;
  f->grid.build(change(of.grid.bounds), f->x, f->y);
  return f;
}

bool is_of_another(const Features& features) { return features.made_by || features.pyramid->base != 1; }

bool same_pixels(const Pinhole& a, const Pinhole& b) {
  return a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.residual == b.residual;
}

}  // namespace

Result<void> express_in(MapState& map, const Camera& made_by, const RefinedCamera& to) {
  const PixelChange change(map.camera, to.pinhole);
  for (const KeyFrameState& k : map.key_frames) {
    const ImageBounds b = change(k.features->grid.bounds);
    const auto within = [](float x) { return std::abs(x) <= kMostPixels; };  // false for what is not a number
    if (!valid_pixel_size(change.base(k.features->pyramid->base)) || !(b.max_x - b.min_x >= 1) ||
        !(b.max_y - b.min_y >= 1) || !within(b.min_x) || !within(b.max_x) || !within(b.min_y) || !within(b.max_y)) {
      return fail("the cameras differ by too much: the images of one have no place in those of the other");
    }
  }
  RefinedCamera from{made_by, map.camera};
  from.given.pinhole.depth_noise = from.pinhole.depth_noise = {};  // no file has them
  from.given.pinhole.registration = from.pinhole.registration = {};
  from.given.pinhole.row_time = from.pinhole.row_time = 0;
  from.given.pinhole.right_columns = from.pinhole.right_columns = {};
  const auto own = std::make_shared<const RefinedCamera>(from);
  Pyramids pyramids;
  const auto straightened_for = to.pinhole.residual.any() ? std::make_shared<const Pinhole>(to.pinhole) : nullptr;
  const auto right_columns = shared_field(to.pinhole.right_columns);
  for (KeyFrameState& k : map.key_frames) {
    const auto features = changed(*k.features, change, to.pinhole.bf, pyramids, straightened_for, right_columns);
    // Files of version 1.4 do not name the cameras of key frames with other pixels: nobody knows them.
    auto& name = features->made_by;
    if (!name && k.features->pyramid->base == 1) name = own;
    if (name && same_lens(name->given, to.given) && same_pixels(name->pinhole, to.pinhole)) name = nullptr;
    features->exposure = {};  // rows are those of the other camera
    k.features = features;
  }
  for (MapPointState& p : map.points) {
    p.d_min *= static_cast<float>(change.size());
    p.d_max *= static_cast<float>(change.size());
  }
  map.camera = to.pinhole;
  return {};
}

void straighten(MapState& map, const Pinhole& camera) {
  for (KeyFrameState& k : map.key_frames)
    if (!straight_for(*k.features, camera)) k.features = straightened(*k.features, camera);
  map.camera = camera;
}

std::vector<RefinedCamera> other_cameras(const MapState& map) {
  std::vector<RefinedCamera> cameras;
  std::unordered_set<const RefinedCamera*> seen;
  for (const KeyFrameState& k : map.key_frames) {
    const RefinedCamera* camera = k.features->made_by.get();
    if (!camera || !seen.insert(camera).second) continue;
    if (std::find(cameras.begin(), cameras.end(), *camera) == cameras.end()) cameras.push_back(*camera);
  }
  return cameras;
}

bool has_other_pixels(const MapState& map) {
  return std::any_of(map.key_frames.begin(), map.key_frames.end(),
                     [](const KeyFrameState& k) { return k.features->pyramid->base != 1; });
}

bool has_other_cameras(const MapState& map) {
  return std::any_of(map.key_frames.begin(), map.key_frames.end(),
                     [](const KeyFrameState& k) { return is_of_another(*k.features); });
}

bool has_other_cameras(const Map& map) {
  bool found = false;
  map.for_each_key_frame(
      [&](KeyFrameId, const KeyFrame& key_frame) { found = found || is_of_another(*key_frame.features); });
  return found;
}

std::vector<uint32_t> metric_submaps(const Map& map) {
  std::vector<uint32_t> metric;
  map.for_each_key_frame([&](KeyFrameId, const KeyFrame& key_frame) {
    const auto at = std::lower_bound(metric.begin(), metric.end(), key_frame.submap);
    if (at != metric.end() && *at == key_frame.submap) return;
    const AlignedVector<float>& depth = key_frame.features->depth;
    if (std::any_of(depth.begin(), depth.end(), [](float d) { return d > 0; })) metric.insert(at, key_frame.submap);
  });
  return metric;
}

}  // namespace covis
