// SPDX-License-Identifier: Apache-2.0
// A desk full of objects, in front of a wall with shelves; the camera sweeps around it at arm's length.
#include <Eigen/Geometry>
#include <numbers>

#include "synth/things/furniture.h"
#include "synth/things/interior.h"
#include "synth/things/materials.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

using std::numbers::pi;

constexpr double kTop = 0.74, kDepth = 0.85, kLength = 1.9;  // size of the desk, metres

void add_book(Scene& scene, const Place& place, double width, double thickness) {
  Random& random = scene.random;
  BoxSkin skin(painted(scene, book_cover(random, 1.4 * width, thickness, 500)));
  skin.front = skin.back = painted(scene, book_row(random, width, thickness, 500));
  skin.top = painted(scene, book_cover(random, width, 1.4 * width, 650));
  add_box(scene, place, 1.4 * width, width, thickness, skin);
}

void add_tin(Scene& scene, const Place& place, double radius, double height) {
  Random& random = scene.random;
  const Skin side = painted(scene, label(random, 2 * pi * radius, height, 650));
  Canvas lid(2 * radius, 2 * radius, 500, 170);
  lid.disc(radius, radius, 0.8 * radius, 90);
  lid.disc(radius, radius, 0.7 * radius, 185);
  lid.fractal(0.03, 15, 4, 0.8, random.next());
  add_prism(scene, place, radius, radius, height, 16, side, painted(scene, lid));
}

void add_carton(Scene& scene, const Place& place, double depth, double width, double height) {
  Random& random = scene.random;
  BoxSkin skin(painted(scene, label(random, width, height, 600)));
  skin.left = skin.right = painted(scene, poster(random, depth, height, 600));
  skin.top = painted(scene, book_cover(random, width, depth, 600));
  add_box(scene, place, depth, width, height, skin);
}

void add_pens(Scene& scene, const Place& place) {
  Random& random = scene.random;
  const Skin dark = material(scene, plaster(random, 0.2, 0.2, 600, 60));
  add_tin(scene, place, 0.04, 0.1);
  for (int i = 0; i < 6; ++i) {
    const Skin pen = material(scene, plaster(random, 0.1, 0.1, 600, random.uniform(30, 230)));
    add_prism(scene, place.at(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.09), 0.005, 0.004,
              random.uniform(0.04, 0.09), 6, pen, dark);
  }
}

void add_desk_lamp(Scene& scene, const Place& place) {
  Random& random = scene.random;
  const Skin metal = material(scene, plaster(random, 0.4, 0.4, 400, random.uniform(50, 210)), 0.15);
  add_prism(scene, place, 0.09, 0.08, 0.025, 16, metal, metal);
  add_prism(scene, place.at(0, 0, 0.025), 0.012, 0.012, 0.36, 8, metal, metal);
  add_box(scene, place.at(0.1, 0, 0.37), 0.24, 0.02, 0.02, BoxSkin(metal), Bottom::closed);
  add_prism(scene, place.at(0.2, 0, 0.28), 0.085, 0.035, 0.1, 14, painted(scene, wallpaper(random, 0.5, 0.1, 500, 180)),
            metal);
}

// Adds a stack of toy blocks.
void add_blocks(Scene& scene, const Place& place) {
  Random& random = scene.random;
  for (int i = 0; i < 7; ++i) {
    const double s = random.uniform(0.04, 0.06);
    Canvas face(s, s, 900, random.uniform(110, 230));
    face.frame(0, 0, s, s, 0.1 * s, random.uniform(20, 90));
    face.text(0.3 * s, 0.22 * s, 0.56 * s, made_up_word(random, 1), 30);
    face.fractal(0.02, 10, 4, 0.8, random.next());
    const double x = (i % 3) * 0.075 - 0.075, z = i < 3 ? 0 : i < 5 ? 0.06 : 0.12;
    add_box(scene,
            place.at(i < 3   ? x
                     : i < 5 ? (i - 3.5) * 0.075
                             : 0,
                     i > 5 ? 0.07 : 0, i > 5 ? 0 : z, random.uniform(-0.5, 0.5)),
            s, s, s, BoxSkin(painted(scene, face)));
  }
}

// Adds the objects on the desk, each in its own cell; `desk` is at the middle of the desk top, facing the camera.
void lay_desk(Scene& scene, const Place& desk) {
  Random& random = scene.random;
  const Skin black = material(scene, plaster(random, 0.5, 0.5, 300, 45));
  const double lean = random.uniform(-0.2, 0.2), aside = random.uniform(-0.15, 0.15);
  const Place monitor = desk.at(-0.2, aside, 0, lean);
  add_box(scene, monitor, 0.18, 0.26, 0.015, BoxSkin(black));
  add_box(scene, monitor.at(-0.03, 0, 0.01), 0.03, 0.06, 0.15, BoxSkin(black));
  add_box(scene, monitor.at(0, 0, 0.09), 0.035, 0.56, 0.34,
          BoxSkin(painted(scene, screen(random, 0.56, 0.34, 700), 0.02), black), Bottom::closed);
  BoxSkin keys(black);
  keys.top = painted(scene, keyboard(random, 0.44, 0.15, 900), 0.03);
  add_box(scene, desk.at(0.18, aside, 0, random.uniform(-0.1, 0.1)), 0.15, 0.44, 0.02, keys);
  add_box(scene, desk.at(0.2, aside + 0.34, 0, random.uniform(-0.4, 0.4)), 0.11, 0.06, 0.035,
          BoxSkin(painted(scene, label(random, 0.06, 0.11, 700))));
  // Loose sheets under the other objects.
  for (int i = 0; i < 5; ++i) {
    const Place sheet =
        desk.at(random.uniform(-0.2, 0.22), random.uniform(-0.75, 0.75), 0.0015 * (i + 1), random.uniform(-0.8, 0.8));
    scene.add_rect(sheet(-0.15, -0.105, 0), sheet.turn(0, 0.21, 0), sheet.turn(0.3, 0, 0),
                   painted(scene, poster(random, 0.21, 0.3, 700), 0.03));
  }
  // Two rows of cells to the left and right of the monitor.
  int kind = static_cast<int>(random.below(8));
  for (const double x : {-0.25, 0.03, 0.27}) {
    for (const double y : {-0.82, -0.6, 0.45, 0.63, 0.83}) {
      if (x > 0.1 && random.below(3) == 0) continue;
      const Place at =
          desk.at(x + random.uniform(-0.04, 0.04), y + random.uniform(-0.03, 0.03), 0.004, random.uniform(-0.5, 0.5));
      if (kind % 8 == 4 && x > 0) ++kind;  // a lamp in front would hide the rest
      switch (kind++ % 8) {
        case 0:
          for (int i = 0; i < 4; ++i)
            add_book(scene, at.at(0, 0, 0.045 * i, random.uniform(-0.3, 0.3)), random.uniform(0.12, 0.15), 0.044);
          break;
        case 1:
          add_tin(scene, at, 0.045, 0.12);
          add_tin(scene, at.at(0.08, 0.06, 0), 0.035, 0.08);
          break;
        case 2:
          add_carton(scene, at, 0.07, 0.15, random.uniform(0.18, 0.26));
          break;
        case 3:
          add_pens(scene, at);
          break;
        case 4:
          add_desk_lamp(scene, at);
          break;
        case 5:
          add_blocks(scene, at);
          break;
        case 6: {
          const Skin pot = painted(scene, wallpaper(random, 0.35, 0.1, 500, 160));
          add_prism(scene, at, 0.045, 0.06, 0.1, 12, pot, black);
          add_foliage(scene, at(0, 0, 0.17), 0.1, 0.045, 30, scene.add_texture(leaves(random, 0.3, 0.3, 400)));
          break;
        }
        default:
          add_book(scene, at, 0.16, 0.03);
          add_tin(scene, at.at(0, 0, 0.03), 0.04, 0.09);
      }
    }
  }
}

CameraPath sweep(const Vector3d& target, uint64_t seed) {
  Random random(seed);
  // Back and forth around the desk, nearer and farther, up and down, always looking at a part of it.
  const double period = 15, interval = 0.25;
  const int count = static_cast<int>(period / interval);
  const double p1 = random.uniform(0, 2 * pi), p2 = random.uniform(0, 2 * pi), p3 = random.uniform(0, 2 * pi);
  std::vector<CameraPose> control;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * pi * i / count;
    const double around = 0.5 * std::sin(a + p1) + 0.25 * std::sin(3 * a + p2),
                 distance = 1.08 + 0.2 * std::sin(2 * a + p2);
    const double up = 0.55 + 0.13 * std::sin(3 * a + p3);
    const Vector3d look = target + Vector3d(0, 0.25 * std::sin(a + p2), 0.08 + 0.06 * std::sin(2 * a + p1));
    CameraPose pose;
    pose.position = target + distance * Vector3d(std::cos(around), std::sin(around), 0) + Vector3d(0, 0, up);
    const Vector3d d = look - pose.position;
    pose.heading = pi + std::atan2(-d.y(), -d.x());
    pose.pitch = std::atan2(d.z(), d.head<2>().norm());
    pose.roll = 0.05 * std::sin(2 * a + p3);
    control.push_back(pose);
  }
  return {std::move(control), interval, 0, {.metres = 0.01, .radians = 0.01}, random.next()};
}

}  // namespace

World make_desk(uint64_t seed) {
  Scene scene(seed);
  Random& random = scene.random;
  const double half = 2.6, depth = 4.6, height = 2.6;
  std::vector<Floor> floors;
  floors.push_back({{0, -half}, floor_canvas(random, 2 * half, depth)});
  const Vector2d corners[4] = {{0, -half}, {0, half}, {depth, half}, {depth, -half}};
  for (int side = 0; side < 4; ++side) {
    const Wall wall{corners[side], corners[(side + 1) % 4], height};
    add_wall_surface(scene, wall);
    if (side == 0) {  // behind the desk: pictures, and cases beside it
      furnish(scene, wall, floors, {Kind::bookcase, Kind::greenery, Kind::cabinet}, 0.3, half + 1.05);
      furnish(scene, wall, floors, {Kind::cabinet, Kind::bookcase, Kind::boxes}, half + 1.05, 0.3);
      for (const double at : {-0.62, 0.0, 0.62}) add_wall_piece(scene, wall.at(half + at), 1.15, 2.2, 0.58);
      const Skin board = material(scene, planks(random, 1, 1, 250, random.uniform(80, 170), 0.5));
      add_box(scene, wall.at(half).at(0.12, 0, 2.25), 0.24, 1.8, 0.025, BoxSkin(board), Bottom::closed);
    } else {
      furnish(scene, wall, floors,
              {Kind::bookcase, Kind::window, Kind::cabinet, Kind::door, Kind::pictures, Kind::greenery}, 0.6, 0.4);
    }
  }
  const Skin wood =
      painted(scene, planks(random, kLength, kDepth, 520, random.uniform(110, 180), random.uniform(0.09, 0.2)), 0.12);
  const Place desk{{0.1 + 0.5 * kDepth, 0, 0}, 0};
  add_shadow(floors, desk.at(-0.5 * kDepth, 0, 0), kDepth, kLength);
  add_table(scene, desk, kDepth, kLength, kTop, wood);
  lay_desk(scene, desk.at(0, 0, kTop));
  floors[0].canvas.darken_edges(0.5, 0.3);
  add_floor(scene, std::move(floors[0]), 0.16);
  scene.add_rect({depth, -half, height}, {0, 2 * half, 0}, {-depth, 0, 0},
                 painted(scene, ceiling_panels(random, 2 * half, depth, 80, 0.6), 0.1));
  return {std::move(scene), sweep({0.55, 0, kTop}, hash_seed(seed, 2)), 30, 600, 0.11};
}

}  // namespace covis::synth
