// SPDX-License-Identifier: Apache-2.0
// A street around a block of houses, driven a little more than once around: fronts of many kinds on both sides, gardens
// between them, parked cars, trees, signs, and a sky.
#include "synth/render/loop_path.h"
#include "synth/things/furniture.h"
#include "synth/things/materials.h"
#include "synth/things/street_things.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

// Metres; kHalf: half the distance between the fronts.
constexpr double kRoad = 7, kWalk = 3.2, kHalf = 0.5 * kRoad + kWalk;

// Adds houses along a line from `left` to `right`, as seen from the street.
void add_row(Scene& scene, const Vector2d& left, const Vector2d& right, const std::vector<int>& leaf_textures) {
  Random& random = scene.random;
  const double length = (right - left).norm();
  const Vector2d r = (right - left) / length;
  const double heading = std::atan2(-r.x(), r.y());
  double at = 0;
  bool garden = true;
  while (length - at > 0.5) {
    double width = random.uniform(8, 14);
    if (length - at - width < 6) width = length - at;
    const Vector2d middle = left + (at + 0.5 * width) * r;
    const Place place{{middle.x(), middle.y(), 0}, heading};
    garden = !garden && random.below(4) == 0;
    if (garden) {
      add_garden(scene, place, width, 9, leaf_textures[random.below(static_cast<uint32_t>(leaf_textures.size()))]);
    } else {
      add_building(scene, place.at(-random.uniform(0, 1.2), 0, 0), width, 9);
    }
    at += width;
  }
}

// Adds cars at the kerb, trees and furniture on the pavement, beside the fronts from `left` to `right`.
void add_kerb(Scene& scene, const Vector2d& left, const Vector2d& right, const std::vector<int>& leaf_textures) {
  Random& random = scene.random;
  const double length = (right - left).norm();
  const Vector2d r = (right - left) / length;
  const double heading = std::atan2(-r.x(), r.y());
  for (double at = random.uniform(3, 6); at < length - 5; at += random.uniform(3.5, 7.5)) {
    const Vector2d p = left + at * r;
    const Place front{{p.x(), p.y(), 0}, heading};
    const uint32_t kind = random.below(8);
    if (kind < 3) {
      add_tree(scene, front.at(kWalk - 0.7, 0, 0.0),
               leaf_textures[random.below(static_cast<uint32_t>(leaf_textures.size()))]);
    } else {
      add_street_furniture(scene, front.at(random.below(3) ? kWalk - 0.5 : 0.9, 0, 0));
    }
    if (random.below(5) < 3) {
      add_car(scene,
              front.at(kWalk + 0.75, 1.5, 0, (random.below(2) ? 1.5708 : -1.5708) + random.uniform(-0.03, 0.03)));
      at += 2;
    }
  }
}

void add_ground(Scene& scene, double ox, double oy, double growth) {
  Random& random = scene.random;
  // All unpaved ground, slightly lower.
  const Skin lawn = material(scene, grass(random, 12, 12, 30), 0.2);
  const double reach = 200 * growth;
  scene.add_rect({-reach, -reach, -0.06}, {0, 2 * reach, 0}, {2 * reach, 0, 0}, lawn);
  enum class Axis { x, y };
  // The two long streets extend over the corners; the short ones run between them.
  const auto strip = [&](const Vector2d& low, double along, Axis axis) {
    const bool along_x = axis == Axis::x;
    const int pieces = std::max(1, static_cast<int>(along / 22));
    const double piece = along / pieces;
    for (int i = 0; i < pieces; ++i) {
      const Vector2d at = low + (along_x ? Vector2d(i * piece, 0) : Vector2d(0, i * piece));
      const Vector3d forward = along_x ? Vector3d(1, 0, 0) : Vector3d(0, 1, 0),
                     side = along_x ? Vector3d(0, 1, 0) : Vector3d(-1, 0, 0);
      const Vector3d base = along_x ? Vector3d(at.x(), at.y(), 0) : Vector3d(at.x() + 2 * kHalf, at.y(), 0);
      const auto lay = [&](double from, double width, double z, const Canvas& canvas) {
        // Seen from above with the driving direction to the right: left is up, so down is to the right.
        scene.add_rect(base + (from + width) * side + Vector3d(0, 0, z), piece * forward, -width * side,
                       painted(scene, canvas, 0.3));
      };
      lay(kWalk, kRoad, 0, road(random, piece, kRoad, 36, random.below(4) == 0 ? Crossing::striped : Crossing::none));
      for (const double from : {0.0, kWalk + kRoad}) {
        lay(from, kWalk, 0.1, pavement(random, piece, kWalk, 36));
        // The edge of the kerb, seen from the road.
        const bool low_side = from == 0.0;
        const Vector3d edge = base + (low_side ? kWalk : kWalk + kRoad) * side + Vector3d(0, 0, 0.1);
        const Skin stone = material(scene, pavement(random, 2, 2, 40), 0.2);
        if (low_side) {
          scene.add_rect(edge + piece * forward, -piece * forward, {0, 0, -0.1}, stone);
        } else {
          scene.add_rect(edge, piece * forward, {0, 0, -0.1}, stone);
        }
      }
    }
  };
  const double w = 2 * kHalf;
  strip({-ox + w, -oy}, 2 * ox - 2 * w, Axis::x);
  strip({-ox + w, oy - w}, 2 * ox - 2 * w, Axis::x);
  strip({-ox, -oy + w}, 2 * oy - 2 * w, Axis::y);
  strip({ox - w, -oy + w}, 2 * oy - 2 * w, Axis::y);
  for (const double x : {-ox, ox - w}) {  // the crossings
    for (const double y : {-oy, oy - w})
      scene.add_rect({x, y, 0}, {0, w, 0}, {w, 0, 0}, painted(scene, road(random, w, w, 36, Crossing::none), 0.3));
  }
}

void add_sky(Scene& scene, double growth) {
  Random& random = scene.random;
  const double far = std::max(2000.0, 200 * growth), high = 1200, low = -40;
  const Vector2d corners[4] = {{-far, -far}, {-far, far}, {far, far}, {far, -far}};
  for (int i = 0; i < 4; ++i) {
    const Vector2d a = corners[i], b = corners[(i + 1) % 4];
    const Skin skin{.texture = scene.add_texture(clouds(random, 4, 1.24, 160, 222, 168)), .detail = 0};
    scene.add_rect({a.x(), a.y(), high}, {b.x() - a.x(), b.y() - a.y(), 0}, {0, 0, low - high}, skin).sky = true;
    // Roofs and trees far behind the houses.
    const Vector2d c = a * 0.065 * growth, d = b * 0.065 * growth;
    const Skin far_houses = painted(scene, skyline(random, (d - c).norm(), 16, 6), 0);
    scene.add_rect({c.x(), c.y(), 15.5}, {d.x() - c.x(), d.y() - c.y(), 0}, {0, 0, -16}, far_houses);
  }
  const Skin top{.texture = scene.add_texture(clouds(random, 4, 4, 100, 168, 168)), .detail = 0};
  scene.add_rect({far, -far, high}, {0, 2 * far, 0}, {-2 * far, 0, 0}, top).sky = true;
}

}  // namespace

World make_street(uint64_t seed, double way) {
  Scene scene(seed);
  scene.detail_metres = 3.2;
  Random& random = scene.random;
  double length = random.uniform(94, 104), width = random.uniform(60, 68);  // size of the centre line's rectangle
  const double growth = way > 0 ? std::max(1.0, 0.5 * way / (length + width)) : 1;
  length *= growth;
  width *= growth;
  const double ox = 0.5 * length + kHalf, oy = 0.5 * width + kHalf, ix = 0.5 * length - kHalf, iy = 0.5 * width - kHalf;
  add_sky(scene, growth);
  add_ground(scene, ox, oy, growth);
  std::vector<int> leaf_textures;
  for (int i = 0; i < 4; ++i) leaf_textures.push_back(scene.add_texture(leaves(random, 3, 3, 60)));
  const Vector2d outer[4] = {{-ox, -oy}, {-ox, oy}, {ox, oy}, {ox, -oy}};
  const Vector2d inner[4] = {{-ix, -iy}, {ix, -iy}, {ix, iy}, {-ix, iy}};
  for (int side = 0; side < 4; ++side) {
    const Vector2d a = outer[side], b = outer[(side + 1) % 4], ab = (b - a).normalized();
    add_row(scene, a, b, leaf_textures);
    add_kerb(scene, a + 2 * kHalf * ab, b - 2 * kHalf * ab, leaf_textures);
    add_row(scene, inner[side], inner[(side + 1) % 4], leaf_textures);
    add_kerb(scene, inner[side], inner[(side + 1) % 4], leaf_textures);
  }
  LoopOptions loop;
  loop.length = length;
  loop.width = width;
  loop.corner = 11;
  loop.fast = 8.5;
  loop.slow = 4.8;
  loop.easing = 14;
  loop.height = 1.65;
  loop.pitch = -0.01;
  loop.weave = 0.5;
  loop.glance = 0.015;
  loop.start = -0.32 * length;
  loop.sway = {.metres = 0.008, .radians = 0.003};
  CameraPath path = make_loop(loop, hash_seed(seed, 2));
  const int frames = static_cast<int>(10 * (path.period() + 3));
  return {std::move(scene), std::move(path), 10, frames, 0.54, {.baseline = 0.54, .units = 256, .reach = 6}};
}

}  // namespace covis::synth
