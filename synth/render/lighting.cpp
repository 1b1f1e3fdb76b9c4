// SPDX-License-Identifier: Apache-2.0
#include "synth/render/lighting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "synth/render/occlusion.h"
#include "synth/render/shading.h"

namespace covis::synth {
namespace {

constexpr double kGamma = 2.2;    // tones are those of an image: light to the power of 1 / gamma
constexpr double kOffset = 5e-4;  // rays begin this far off their surface, metres
constexpr double kFar = 1e4;      // more than the extent of a scene, metres
constexpr size_t kSpread = 4;     // points of a light and of a texel that are tried

// A light with an extent: each of its points is tried from another part of a texel.
struct Lamp {
  std::array<Vector3d, kSpread> points;
  Vector3d axis;  // direction in which it shines most
  double spill;   // share of that in all other directions
  double power;   // light on a surface that faces it at 1 m
  int own = -1;   // the polygon it is, if any
};

// The sun outdoors, or through windows.
struct Sun {
  Vector3d towards = Vector3d::UnitZ();
  double power = 0;
};

struct Lights {
  std::vector<Lamp> lamps;
  Sun sun;
  double ambient = 0, from_above = 0;  // light from all around, and more of it on what faces the sky
};

// A point of a surface.
struct Spot {
  Vector3d at, normal;
  int polygon;
};

bool outdoors(const Scene& scene) {
  return std::any_of(scene.polygons.begin(), scene.polygons.end(), [](const Polygon& p) { return p.sky; });
}

class Illumination {
 public:
  Illumination(const Scene& scene, const Lights& lights)
      : scene_(scene), lights_(lights), outdoors_(outdoors(scene)), occlusion_(scene) {}

  const Occlusion& occlusion() const { return occlusion_; }

  // Returns the light on a spot, as it is from the point `part` of each lamp.
  double at(const Spot& spot, size_t part) const {
    const bool two_sided = scene_.polygons[static_cast<size_t>(spot.polygon)].two_sided;
    double sum = lights_.ambient + lights_.from_above * std::max(0.0, spot.normal.z());
    const auto facing = [&](const Vector3d& direction) {
      const double cosine = spot.normal.dot(direction);
      return two_sided ? std::abs(cosine) : cosine;
    };
    const auto start = [&](const Vector3d& direction) {
      return Vector3d(spot.at + (spot.normal.dot(direction) < 0 ? -kOffset : kOffset) * spot.normal);
    };
    const Sun& sun = lights_.sun;
    if (const double cosine = facing(sun.towards); sun.power > 0 && cosine > 0) {
      const auto hit = occlusion_.first(start(sun.towards), sun.towards, kFar, spot.polygon);
      if (outdoors_ ? !hit : hit && through_window(hit->polygon, sun.towards)) sum += sun.power * cosine;
    }
    for (const Lamp& lamp : lights_.lamps) {
      constexpr double kSize2 = 0.15 * 0.15, kFaint = 0.01;  // m^2, light that is not worth a ray
      if (lamp.own == spot.polygon) continue;
      const Vector3d way = lamp.points[part] - spot.at;
      const double distance = way.norm(), cosine = facing(way) / distance;
      if (cosine <= 0) continue;
      const double shine = lamp.spill + (1 - lamp.spill) * std::max(0.0, -lamp.axis.dot(way) / distance);
      const double light = lamp.power * shine * cosine / (distance * distance + kSize2);
      if (light > kFaint && !occlusion_.blocked(start(way), lamp.points[part], spot.polygon)) sum += light;
    }
    return sum;
  }

 private:
  bool through_window(int polygon, const Vector3d& towards) const {
    const Polygon& p = scene_.polygons[static_cast<size_t>(polygon)];
    return p.window && p.normal.dot(towards) < 0;
  }

  const Scene& scene_;
  const Lights& lights_;
  const bool outdoors_;
  const Occlusion occlusion_;
};

Vector3d direction(double heading, double elevation) {
  return {std::cos(elevation) * std::cos(heading), std::cos(elevation) * std::sin(heading), std::sin(elevation)};
}

// Lamps beside the path, a few metres apart, under the ceiling or standing about as high as the camera; some are off.
std::vector<Lamp> hang_lamps(const Occlusion& occlusion, const CameraPath& path, Random& random) {
  constexpr double kStep = 0.1, kBelow = 0.25;  // seconds; metres below the ceiling
  std::vector<Lamp> lamps;
  double way = 0, next = random.uniform(0, 1.5);
  Vector3d before = path.at(0).position;
  for (double t = 0; t < path.period(); t += kStep) {
    const Vector3d at = path.at(t).position;
    way += (at - before).norm();
    before = at;
    if (way < next) continue;
    next = way + random.uniform(2, 4.5);
    const Vector3d aside = direction(random.uniform(0, 2 * std::numbers::pi), 0);
    double off = random.uniform(0.2, 1.6);
    if (const auto wall = occlusion.first(at, aside, off + 0.3, -1)) off = std::max(0.0, wall->distance - 0.3);
    const Vector3d foot = at + off * aside;
    const auto ceiling = occlusion.first(foot, Vector3d::UnitZ(), 4, -1);
    const bool hangs = random.below(2) == 0;
    const double up = hangs ? std::max(0.3, (ceiling ? ceiling->distance : 1.2) - kBelow) : random.uniform(-0.4, 0.3);
    const double size = random.uniform(0.02, 0.12), power = hangs ? random.uniform(1.5, 6) : random.uniform(0.7, 2.5);
    const double spill = hangs ? random.uniform(0.1, 0.5) : 1;
    if (random.uniform() > 0.6 && !lamps.empty()) continue;  // it is off
    Lamp lamp{.points = {}, .axis = -Vector3d::UnitZ(), .spill = spill, .power = power};
    for (size_t k = 0; k < kSpread; ++k) {
      lamp.points[k] = foot + Vector3d(k & 1 ? size : -size, k & 2 ? size : -size, up);
    }
    lamps.push_back(lamp);
  }
  return lamps;
}

Lamp window_lamp(const Scene& scene, int polygon, double daylight) {
  const Polygon& p = scene.polygons[static_cast<size_t>(polygon)];
  Lamp lamp{.points = {}, .axis = p.normal, .spill = 0, .power = 0, .own = polygon};
  const auto corner = [&](int i) { return scene.vertices[static_cast<size_t>(p.first + i % p.count)]; };
  double area = 0;
  for (int i = 1; i + 1 < p.count; ++i) area += 0.5 * (corner(i) - corner(0)).cross(corner(i + 1) - corner(0)).norm();
  for (size_t k = 0; k < kSpread; ++k) {
    lamp.points[k] = 0.5 * (corner(static_cast<int>(k)) + p.centre) + 0.01 * p.normal;
  }
  lamp.power = daylight * area;
  return lamp;
}

// By day windows shine and the sun may shine through them; by night they are dark.
Lights indoor_lights(Scene& scene, const CameraPath& path, Random& random) {
  const Occlusion occlusion(scene);
  Lights lights{.lamps = hang_lamps(occlusion, path, random), .sun = {}, .ambient = random.uniform(0.05, 0.15)};
  lights.from_above = 0.5 * lights.ambient;
  std::vector<int> windows;
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    if (scene.polygons[k].window) windows.push_back(static_cast<int>(k));
  }
  const bool day = random.uniform() < 0.6;
  if (windows.empty()) return lights;
  if (!day) {
    for (const int k : windows) scene.polygons[static_cast<size_t>(k)].gain *= 0.3f;
    return lights;
  }
  const double daylight = random.uniform(1, 3.5);
  for (const int k : windows) lights.lamps.push_back(window_lamp(scene, k, daylight));
  const int facing = windows[random.below(static_cast<uint32_t>(windows.size()))];
  const Vector3d in = scene.polygons[static_cast<size_t>(facing)].normal;
  lights.sun.towards = direction(std::atan2(-in.y(), -in.x()) + random.uniform(-0.8, 0.8), random.uniform(0.35, 0.85));
  if (random.uniform() < 0.7) lights.sun.power = random.uniform(2, 6);
  return lights;
}

Lights outdoor_lights(Random& random) {
  Lights lights;
  lights.ambient = 0.75;
  lights.from_above = 0.35;
  lights.sun.towards = direction(random.uniform(0, 2 * std::numbers::pi), random.uniform(0.5, 1.2));
  lights.sun.power = random.uniform(3.5, 8);
  return lights;
}

// Returns the factor that makes what a camera on the path sees as bright in the mean as without a light map.
double exposure(const Scene& scene, const CameraPath& path, const Illumination& light) {
  constexpr int kViews = 60;
  constexpr double kSteps[] = {-0.5, -0.25, 0, 0.25, 0.5};  // of the ray, across the view
  double sum = 0;
  int count = 0;
  for (int i = 0; i < kViews; ++i) {
    const SE3 T_wc = path.at(path.period() * i / kViews).T_wc();
    for (const double x : kSteps) {
      for (const double y : kSteps) {
        const Vector3d ray = T_wc.R() * Vector3d(x, y, 1);
        const auto hit = light.occlusion().first(T_wc.t(), ray, kFar, -1);
        if (!hit) continue;
        const Spot spot{T_wc.t() + hit->distance * ray, scene.polygons[static_cast<size_t>(hit->polygon)].normal,
                        hit->polygon};
        sum += std::pow(light.at(spot, static_cast<size_t>(count) % kSpread), 1 / kGamma);
        ++count;
      }
    }
  }
  return count > 0 && sum > 0 ? count / sum : 1;
}

// The plane of a polygon by its texture coordinates, and the polygon's extent in these.
struct Extent {
  Vector3d origin, right, down;  // origin: u = v = 0
  double u_low = 1e30, u_high = -1e30, v_low = 1e30, v_high = -1e30;

  Extent(const Scene& scene, const Polygon& p) {
    const Vector3d across = p.v_w.cross(p.normal), along = p.normal.cross(p.u_w);
    right = across / p.u_w.dot(across);
    down = along / p.v_w.dot(along);
    for (int i = 0; i < p.count; ++i) {
      const Vector3d& corner = scene.vertices[static_cast<size_t>(p.first + i)];
      const double u = p.u_w.dot(corner) + p.u_0, v = p.v_w.dot(corner) + p.v_0;
      u_low = std::min(u_low, u);
      u_high = std::max(u_high, u);
      v_low = std::min(v_low, v);
      v_high = std::max(v_high, v);
      if (i == 0) origin = corner - u * right - v * down;
    }
  }
};

class Lattice {
 public:
  Lattice(double metres, double exposure) : metres_(metres), exposure_(exposure) {}

  LightMap over(const Scene& scene, int polygon, const Illumination& light) const {
    const Polygon& p = scene.polygons[static_cast<size_t>(polygon)];
    const Extent extent(scene, p);
    const double width = extent.u_high - extent.u_low, height = extent.v_high - extent.v_low;
    const auto texels = [&](double length) {
      return std::clamp(static_cast<int>(std::ceil(length / metres_)), 2, kMostTexels);
    };
    const int columns = texels(width * extent.right.norm()), rows = texels(height * extent.down.norm());
    std::vector<float> tones;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        double sum = 0;
        for (size_t part = 0; part < kSpread; ++part) {
          const double u = extent.u_low + width * (c + (part & 1 ? 0.75 : 0.25)) / columns;
          const double v = extent.v_low + height * (r + (part & 2 ? 0.75 : 0.25)) / rows;
          sum += light.at({extent.origin + u * extent.right + v * extent.down, p.normal, polygon}, part);
        }
        const double factor = exposure_ * std::pow(sum / kSpread, 1 / kGamma);
        tones.push_back(static_cast<float>(kLightAsPainted * factor));
      }
    }
    return {Texture(std::move(tones), columns, rows), static_cast<float>(1 / width), static_cast<float>(1 / height),
            static_cast<float>(-extent.u_low / width), static_cast<float>(-extent.v_low / height)};
  }

 private:
  static constexpr int kMostTexels = 256;
  double metres_, exposure_;
};

}  // namespace

void relight(Scene& scene, const CameraPath& path, uint64_t seed) {
  constexpr double kIndoors = 0.03, kOutdoors = 0.2;  // distance of the light maps' texels, metres
  Random random(seed);
  const bool in_the_open = outdoors(scene);
  const Lights lights = in_the_open ? outdoor_lights(random) : indoor_lights(scene, path, random);
  const Illumination light(scene, lights);
  const Lattice lattice(in_the_open ? kOutdoors : kIndoors, exposure(scene, path, light));
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    Polygon& polygon = scene.polygons[k];
    if (polygon.sky || polygon.window) continue;
    polygon.light_map = static_cast<int>(scene.light_maps.size());
    scene.light_maps.push_back(lattice.over(scene, static_cast<int>(k), light));
  }
}

}  // namespace covis::synth
