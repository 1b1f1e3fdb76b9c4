// SPDX-License-Identifier: Apache-2.0
#include "covis/map/camera_change.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

namespace covis {
namespace {

// From the pixels of one camera to those of another.
struct PixelChange {
  double ax, bx, ay, by;

  PixelChange(const Pinhole& from, const Pinhole& to)
      : ax(to.fx / from.fx), bx(to.cx - ax * from.cx), ay(to.fy / from.fy), by(to.cy - ay * from.cy) {}
  float x(float u) const { return static_cast<float>(ax * static_cast<double>(u) + bx); }
  float y(float v) const { return static_cast<float>(ay * static_cast<double>(v) + by); }
  ImageBounds operator()(const ImageBounds& b) const { return {x(b.min_x), y(b.min_y), x(b.max_x), y(b.max_y)}; }
};

using Pyramids = std::map<const ScalePyramid*, std::shared_ptr<const ScalePyramid>>;

FeaturesPtr changed(const Features& of, const PixelChange& change, double bf, Pyramids& pyramids) {
  auto f = std::make_shared<Features>(of);
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
    pyramid = std::make_shared<ScalePyramid>(p.levels, p.factor,
                                             p.base * static_cast<float>(std::sqrt(change.ax * change.ay)));
  }
  f->pyramid = pyramid;
  f->grid.build(change(of.grid.bounds), f->x, f->y);
  return f;
}

}  // namespace

void express_in(MapState& map, const Pinhole& camera) {
  const PixelChange change(map.camera, camera);
  const auto size = static_cast<float>(std::sqrt(change.ax * change.ay));
  Pyramids pyramids;
  for (KeyFrameState& k : map.key_frames) k.features = changed(*k.features, change, camera.bf, pyramids);
  for (MapPointState& p : map.points) {
    p.d_min *= size;
    p.d_max *= size;
  }
  map.camera = camera;
}

bool knows_metres(const Map& map, uint32_t submap) {
  const std::vector<KeyFrameId> frames = map.key_frames(submap);
  return std::any_of(frames.begin(), frames.end(), [&](KeyFrameId id) {
    const AlignedVector<float>& depth = map.at(id).features->depth;
    return std::any_of(depth.begin(), depth.end(), [](float d) { return d > 0; });
  });
}

}  // namespace covis
