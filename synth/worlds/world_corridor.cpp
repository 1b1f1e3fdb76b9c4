// SPDX-License-Identifier: Apache-2.0
// An office corridor around a block of rooms: four legs of different appearance and a wider area at each corner, walked
// a little more than once around.
#include "synth/render/loop_path.h"
#include "synth/things/furniture.h"
#include "synth/things/interior.h"
#include "synth/things/materials.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

constexpr double kWidth = 2.7, kHeight = 2.75, kCut = 1.3;  // metres; the inner corners are cut off at 45 degrees

// Adds lamps, beams, signs and pipes under the ceiling of a leg from `begin` to `end`.
void furnish_ceiling(Scene& scene, const Vector2d& begin, const Vector2d& end) {
  Random& random = scene.random;
  const Vector2d along = (end - begin).normalized();
  const double heading = std::atan2(along.y(), along.x());
  const auto place = [&](double s, double aside, double z) {
    const Vector2d p = begin + s * along + aside * Vector2d(-along.y(), along.x());
    return Place{{p.x(), p.y(), z}, heading};
  };
  const double length = (end - begin).norm();
  const Skin lamp = material(scene, plaster(random, 0.5, 0.5, 150, 245), 0.02);
  const Skin beam = material(scene, plaster(random, 1.5, 1.5, 130, random.uniform(120, 190)), 0.2);
  const Skin metal = material(scene, plaster(random, 0.8, 0.8, 200, random.uniform(70, 170)), 0.2);
  for (double s = 1; s < length - 0.5; s += random.uniform(1.5, 2.6)) {
    switch (random.below(4)) {
      case 0:
      case 1:
        add_box(scene, place(s, random.uniform(-0.3, 0.3), kHeight - 0.08), 1.1, 0.22, 0.08, BoxSkin(lamp),
                Bottom::closed);
        break;
      case 2:
        add_box(scene, place(s, 0, kHeight - 0.3), 0.22, kWidth, 0.3, BoxSkin(beam), Bottom::closed);
        break;
      default: {  // a hanging sign
        Canvas sign(0.9, 0.25, 300, random.uniform(30, 110));
        sign.text(0.06, 0.07, 0.11, made_up_word(random, 8), 235);
        BoxSkin skin(painted(scene, sign, 0.05));
        skin.back = skin.front;
        add_box(scene, place(s, random.uniform(-0.4, 0.4), kHeight - 0.42), 0.05, 0.9, 0.25, skin, Bottom::closed);
        for (const double y : {-0.35, 0.35})
          add_box(scene, place(s, y, kHeight - 0.17), 0.015, 0.015, 0.17, BoxSkin(metal));
      }
    }
  }
  if (random.below(3)) {  // a pipe along one side
    const double side = random.below(2) ? 1 : -1;
    add_box(scene, place(0.5 * length, side * (0.5 * kWidth - 0.2), kHeight - 0.28), length, 0.09, 0.09, BoxSkin(metal),
            Bottom::closed);
  }
}

}  // namespace

World make_corridor(uint64_t seed) {
  Scene scene(seed);
  Random& random = scene.random;
  const double length = random.uniform(17, 20), width = random.uniform(12, 14);  // size of the centre line's rectangle
  const double ox = 0.5 * (length + kWidth), oy = 0.5 * (width + kWidth);        // outer half sizes
  const double ix = 0.5 * (length - kWidth), iy = 0.5 * (width - kWidth);

  std::vector<Floor> floors;
  floors.push_back({{-ox, -oy}, floor_canvas(random, kWidth, 2 * ox)});
  floors.push_back({{-ox, iy}, floor_canvas(random, kWidth, 2 * ox)});
  // These two extend under the cut-off corners.
  floors.push_back({{-ox, -iy}, floor_canvas(random, 2 * iy, kWidth + kCut)});
  floors.push_back({{ix - kCut, -iy}, floor_canvas(random, 2 * iy, kWidth + kCut)});

  const std::vector<Kind> flat{Kind::door,    Kind::pictures, Kind::pillar, Kind::cabinet, Kind::window,  Kind::door,
                               Kind::lockers, Kind::bookcase, Kind::bench,  Kind::pillar,  Kind::pictures};
  const std::vector<Kind> corner{Kind::machine, Kind::greenery, Kind::sofa, Kind::boxes, Kind::bookcase};
  // The outer walls, going clockwise around the block, as seen from inside.
  const Vector2d outer[4] = {{-ox, -oy}, {-ox, oy}, {ox, oy}, {ox, -oy}};
  for (int side = 0; side < 4; ++side) {
    const Wall wall{outer[side], outer[(side + 1) % 4], kHeight};
    add_wall_surface(scene, wall);
    furnish(scene, wall, floors, corner, 0.6, wall.length() - kWidth + 0.4);
    furnish(scene, wall, floors, flat, kWidth, kWidth);
    furnish(scene, wall, floors, corner, wall.length() - kWidth + 0.6, 0.2);
  }
  // The inner walls go the other way around, with their corners cut off.
  const Vector2d inner[4] = {{-ix, -iy}, {ix, -iy}, {ix, iy}, {-ix, iy}};
  for (int side = 0; side < 4; ++side) {
    const Vector2d a = inner[side], b = inner[(side + 1) % 4], c = inner[(side + 2) % 4];
    const Vector2d ab = (b - a).normalized(), bc = (c - b).normalized();
    const Wall wall{a + kCut * ab, b - kCut * ab, kHeight};
    add_wall_surface(scene, wall);
    furnish(scene, wall, floors, flat, 0.1, 0.1);
    const Wall cut{b - kCut * ab, b + kCut * bc, kHeight};
    add_wall_surface(scene, cut);
    furnish(scene, cut, floors, {Kind::pictures, Kind::door}, 0.2, 0.1);
  }
  for (Floor& floor : floors) {
    floor.canvas.darken_edges(0.4, 0.2);
    add_floor(scene, std::move(floor), 0.16);
  }
  const auto ceiling = [&](double x0, double y0, double x1, double y1) {
    Canvas panels = ceiling_panels(random, y1 - y0, x1 - x0, 70, random.uniform(0.5, 0.7));
    scene.add_rect({x1, y0, kHeight}, {0, y1 - y0, 0}, {x0 - x1, 0, 0}, painted(scene, panels, 0.1));
  };
  ceiling(-ox, -oy, ox, -iy);
  ceiling(-ox, iy, ox, oy);
  ceiling(-ox, -iy, -ix + kCut, iy);
  ceiling(ix - kCut, -iy, ox, iy);
  const double mx = 0.5 * length, my = 0.5 * width;
  furnish_ceiling(scene, {-ix, -my}, {ix, -my});
  furnish_ceiling(scene, {mx, -iy}, {mx, iy});
  furnish_ceiling(scene, {ix, my}, {-ix, my});
  furnish_ceiling(scene, {-mx, iy}, {-mx, -iy});

  LoopOptions loop;
  loop.length = length;
  loop.width = width;
  loop.corner = 1.8;
  loop.fast = 1.4;
  loop.slow = 0.85;
  loop.easing = 1.5;
  loop.height = 1.45;
  loop.pitch = -0.05;
  loop.weave = 0.12;
  loop.glance = 0.1;
  loop.start = -0.3 * length;
  loop.sway = {.metres = 0.01, .radians = 0.008};
  CameraPath path = make_loop(loop, hash_seed(seed, 2));
  const int frames = static_cast<int>(30 * (path.period() + 4));
  return {std::move(scene), std::move(path), 30, frames, 0.11};
}

}  // namespace covis::synth
