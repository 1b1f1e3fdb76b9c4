// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/point_creation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "covis/geometry/triangulation.h"
#include "covis/map/map_edit.h"
#include "covis/matching/epipolar_match.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

struct View {
  const SE3& T_cw;
  SE3 T_wc;
  FeaturesPtr features;

  explicit View(const KeyFrameView& view) : T_cw(view.T_cw), T_wc(view.T_cw.inverse()), features(view.features) {}
};

// Cosine of the parallax that a triangulation needs to be as good as the depth of a feature: the angle under which the
// two eyes of a stereo camera see it, or that under which a pixel makes as great an error as the depth sensor does.
double depth_cosine(const Pinhole& camera, const Features& features, uint32_t i) {
  const double z = features.depth[i];
  if (!(z > 0)) return 2;  // above any cosine: no depth
  if (!camera.depth_noise.known()) return std::cos(2 * std::atan2(camera.baseline() / 2, z));
  const double pixels = features.pyramid->scale[features.level[i]];
  return std::cos(std::atan(pixels * z / (camera.fx * camera.depth_noise.sigma(z))));
}

// The place of a matched pair of features, by the better of triangulation and depth.
std::optional<Eigen::Vector3d> place(const Pinhole& camera, const View& a, uint32_t ia, const View& b, uint32_t ib) {
  constexpr double kMaxCosine = 0.9998;  // least parallax of a triangulation without depth
  const Features& fa = *a.features;
  const Features& fb = *b.features;
  const Eigen::Vector3d ray_a = camera.unproject(fa.x[ia], fa.y[ia]);
  const Eigen::Vector3d ray_b = camera.unproject(fb.x[ib], fb.y[ib]);
  const double cosine = (a.T_wc.R() * ray_a).dot(b.T_wc.R() * ray_b) / (ray_a.norm() * ray_b.norm());
  const double depth_a = depth_cosine(camera, fa, ia), depth_b = depth_cosine(camera, fb, ib);
  const bool any_depth = depth_a <= 1 || depth_b <= 1;
  if (cosine > 0 && cosine < std::min(depth_a, depth_b) && (any_depth || cosine < kMaxCosine)) {
    return triangulate(a.T_cw, ray_a, b.T_cw, ray_b);
  }
  if (!any_depth) return std::nullopt;
  return depth_a < depth_b ? a.T_wc * unproject_depth(camera, fa, ia) : b.T_wc * unproject_depth(camera, fb, ib);
}

// True when the point is in front of both, near its pixels in both, and seen from like distances at like levels.
bool holds(const Eigen::Vector3d& p_w, const Pinhole& camera, const View& a, uint32_t ia, const View& b, uint32_t ib) {
  if (!p_w.allFinite()) return false;
  const Eigen::Vector3d in_a = a.T_cw * p_w, in_b = b.T_cw * p_w;
  if (!reprojects_well(in_a, camera, *a.features, ia) || !reprojects_well(in_b, camera, *b.features, ib)) return false;
  const double distance_a = in_a.norm(), distance_b = in_b.norm();
  if (!(distance_a > 0) || !(distance_b > 0)) return false;
  const ScalePyramid &of_a = *a.features->pyramid, &of_b = *b.features->pyramid;
  // The ratios would agree with by_level turned round, as things look smaller from farther away. So points pass that
  // are seen at about one level, and few others: letting all right points pass makes no map better
  // (docs/notes/008-mapping-figures.md).
  const double by_distance = distance_b / distance_a;
  const double by_level = of_b.scale[b.features->level[ib]] / of_a.scale[a.features->level[ia]];
  const double tolerance = 1.5 * static_cast<double>(of_a.factor);
  return by_distance < by_level * tolerance && by_distance * tolerance > by_level;
}

// Too near each other for a triangulation: less than the stereo baseline, or than a share of the scene's depth (the
// neighbour's median).
bool too_near(const Pinhole& camera, Sensor sensor, const View& a, const View& b, const KeyFrameView& neighbour) {
  constexpr double kMinShare = 0.01, kMinShareRgbd = 0.03;
  const double baseline = (a.T_wc.t() - b.T_wc.t()).norm();
  if (!(camera.bf > 0) || camera.depth_noise.known())
    return baseline < (sensor == Sensor::monocular ? kMinShare : kMinShareRgbd) * median_depth(neighbour);
  return baseline < camera.baseline();
}

// What looks alike at several places of its epipolar line, as tiles do, has no certain depth. Where a sensor
// gives most depths the few other points, mostly far ones, are needed, and wrong ones harm less: there the ratio makes
// paths worse (docs/notes/025-one-place-on-the-line.md).
constexpr double kRatioMono = 0.7;

}  // namespace

PointTriangulation::PointTriangulation(const Pinhole& camera, Sensor sensor, KeyFrameView current)
    : camera_(camera),
      sensor_(sensor),
      current_(std::move(current)),
      is_free_(features_without_point(current_.points)) {}

void PointTriangulation::add(const KeyFrameView& neighbour) {
  const View a(current_), b(neighbour);
  if (too_near(camera_, sensor_, a, b, neighbour)) return;
  const std::vector<uint8_t> is_free_b = features_without_point(neighbour.points);
  const SE3 T_ba = b.T_cw * a.T_wc;
  EpipolarMatchOptions options;
  if (sensor_ == Sensor::monocular) options.max_ratio = kRatioMono;
  for (const FeatureMatch& m : match_epipolar(camera_, *a.features, is_free_, *b.features, is_free_b, T_ba, options)) {
    const auto ia = static_cast<uint32_t>(m.a), ib = static_cast<uint32_t>(m.b);
    const auto p_w = place(camera_, a, ia, b, ib);
    if (!p_w || !holds(*p_w, camera_, a, ia, b, ib)) continue;
    made_.push_back({*p_w, neighbour.id, ia, ib});
    is_free_[ia] = 0;
  }
}

namespace {

// Copies one neighbour at a time: all of them would be a megabyte of points.
std::vector<TriangulatedPoint> triangulate(const SharedMap& shared, KeyFrameId current, Sensor sensor, int count) {
  const auto start = [&] {
    const auto map = shared.read();
    return std::pair(PointTriangulation(map->camera(), sensor, KeyFrameView(*map, current)),
                     map->best_neighbours(current, count));
  };
  auto [triangulation, neighbours] = start();
  KeyFrameView view;
  for (const Neighbour& neighbour : neighbours) {
    view.copy(*shared.read(), neighbour.key_frame);
    triangulation.add(view);
  }
  return triangulation.made();
}

}  // namespace

int create_points(SharedMap& shared, KeyFrameId current, Sensor sensor, const MapperOptions& options,
                  RecentPoints& recent) {
  const std::vector<TriangulatedPoint> made = triangulate(shared, current, sensor, options.neighbours(sensor));
  MapEdit map(shared);
  const uint32_t serial = map->at(current).serial;
  int created = 0;
  for (const TriangulatedPoint& point : made) {
    if (!map->find(point.neighbour)) continue;
    const MapPointId id = map.add_point(point.position_w, current, point.feature);
    if (!id.valid()) continue;
    map.add_observation(id, point.neighbour, point.neighbour_feature);
    recent.add(id, serial);
    ++created;
  }
  return created;
}

}  // namespace covis
