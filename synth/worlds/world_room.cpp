// SPDX-License-Identifier: Apache-2.0
// A living and working room: furniture along the walls, a table in the middle, and a walk around the table that sees
// all of the room and passes its beginning again.
#include <numbers>

#include "synth/things/furniture.h"
#include "synth/things/interior.h"
#include "synth/things/materials.h"
#include "synth/things/table_group.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

using std::numbers::pi;

struct Size {
  double length, width, height;  // along x, y, z
};

CameraPath tour(const Size& room, uint64_t seed) {
  Random random(seed);
  // One round in `period` seconds at about half a metre per second, looking at the walls, partly ahead, partly back.
  const double period = 17, interval = 0.5;
  const double rx = 0.5 * room.length - 2.2, ry = 0.5 * room.width - 1.9, start = random.uniform(0, 2 * pi);
  const double p1 = random.uniform(0, 2 * pi), p2 = random.uniform(0, 2 * pi);
  std::vector<CameraPose> control;
  const int count = static_cast<int>(period / interval);
  for (int i = 0; i < count; ++i) {
    const double a = start + 2 * pi * i / count;
    CameraPose pose;
    pose.position = {0.5 * room.length + rx * std::cos(a), 0.5 * room.width + ry * std::sin(a),
                     1.35 + 0.12 * std::sin(2 * a + p1)};
    pose.heading = a + 0.45 + 0.3 * std::sin(2 * a + p2);
    pose.pitch = -0.14 + 0.13 * std::sin(3 * a + p1);
    control.push_back(pose);
  }
  return {std::move(control), interval, 1, {.metres = 0.012, .radians = 0.012}, random.next()};
}

}  // namespace

World make_room(uint64_t seed) {
  Scene scene(seed);
  Random& random = scene.random;
  const Size room{random.uniform(6.6, 7.6), random.uniform(5.6, 6.3), random.uniform(2.5, 2.8)};
  std::vector<Floor> floors;
  floors.push_back({{0, 0}, floor_canvas(random, room.width, room.length)});
  const Vector2d corners[4] = {{0, 0}, {0, room.width}, {room.length, room.width}, {room.length, 0}};
  for (int side = 0; side < 4; ++side) {
    const Wall wall{corners[side], corners[(side + 1) % 4], room.height};
    add_wall_surface(scene, wall);
    furnish(scene, wall, floors,
            {Kind::bookcase, Kind::desk, Kind::cabinet, Kind::sofa, Kind::boxes, Kind::window, Kind::greenery,
             Kind::bookcase, Kind::door},
            0.5, 0.4);
  }
  add_table_group(scene, {0.5 * room.length, 0.5 * room.width}, floors);
  floors[0].canvas.darken_edges(0.5, 0.3);
  add_floor(scene, floors[0], 0.16);
  Canvas ceiling = ceiling_panels(random, room.width, room.length, 90, 0.6);
  ceiling.darken_edges(0.6, 0.3);
  scene.add_rect({room.length, 0, room.height}, {0, room.width, 0}, {-room.length, 0, 0}, painted(scene, ceiling, 0.1));
  const Skin lamp = material(scene, plaster(random, 0.5, 0.5, 150, 245), 0.02);
  for (const double x : {0.3, 0.7}) {
    add_box(scene, {{x * room.length, 0.5 * room.width, room.height - 0.08}, 0}, 0.25, 1.2, 0.08, BoxSkin(lamp),
            Bottom::closed);
  }
  return {std::move(scene), tour(room, hash_seed(seed, 2)), 30, 600, 0.11};
}

}  // namespace covis::synth
