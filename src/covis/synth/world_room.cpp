// SPDX-License-Identifier: Apache-2.0
// A living and working room: furniture along the walls, a table in the middle, and a walk around the table that looks
// at all of it and comes by its beginning again.
#include <numbers>

#include "covis/synth/furniture.h"
#include "covis/synth/materials.h"
#include "covis/synth/world.h"

namespace covis::synth {
namespace {

using std::numbers::pi;

struct Walls {
  double length, width, height;  // x, y, z
};

// The place on wall `side` (0: x = 0, looking +x; 1: y = 0; 2: x = length; 3: y = width), `along` metres from its
// middle.
Place on_wall(const Walls& room, int side, double along) {
  switch (side) {
    case 0:
      return {{0, 0.5 * room.width + along, 0}, 0};
    case 1:
      return {{0.5 * room.length - along, 0, 0}, 0.5 * pi};
    case 2:
      return {{room.length, 0.5 * room.width - along, 0}, pi};
    default:
      return {{0.5 * room.length + along, room.width, 0}, -0.5 * pi};
  }
}

Canvas wall_canvas(Random& random, double w, double h) {
  const double tone = random.uniform(135, 190);
  Canvas c = [&] {
    switch (random.below(4)) {
      case 0:
        return bricks(random, w, h, 150, tone - 25);
      case 1:
        return plaster(random, w, h, 130, tone);
      default:
        return wallpaper(random, w, h, 140, tone);
    }
  }();
  c.rect(0, h - 0.12, w, h, tone - 80);  // skirting board
  c.line(0, h - 0.12, w, h - 0.12, 0.01, tone + 30);
  c.darken_edges(0.5, 0.25);
  return c;
}

// A window: reveal, frame, sill, and the view a little behind the wall, so that it moves against the frame.
void add_window(Scene& scene, const Place& wall, double width, double height, double sill) {
  Random& random = scene.random;
  const Skin frame = material(scene, plaster(random, 0.5, 0.5, 200, 220));
  const double bar = 0.06;
  add_box(scene, wall.at(0.06, 0, sill - 0.04), 0.26, width + 0.2, 0.04, BoxSkin(frame), true);
  for (int i = 0; i <= 2; ++i) {
    add_box(scene, wall.at(0.03, (i - 1) * 0.5 * (width - bar), sill), 0.06, bar, height, BoxSkin(frame));
  }
  for (const double z : {0.0, 0.6 * height, height - bar})
    add_box(scene, wall.at(0.028, 0, sill + z), 0.055, width, bar, BoxSkin(frame), true);
  Skin view = painted(scene, view_outside(random, width, height, 240));
  view.gain = 1.1;
  scene.add_rect(wall(0.004, -0.5 * width, sill + height), wall.turn(0, width, 0), {0, 0, -height}, view);
  for (const double side : {-1.0, 1.0}) {  // curtains, in folds
    const Skin cloth = material(scene, fabric(random, 0.7, 1.5, 150, random.uniform(90, 200)));
    for (int k = 0; k < 4; ++k) {
      add_box(scene, wall.at(0.1 + 0.03 * (k % 2), side * (0.5 * width + 0.02 + 0.08 * k), sill - 0.3), 0.06, 0.085,
              height + 0.5, BoxSkin(cloth));
    }
  }
}

// Fills a wall from left to right with things of different kinds; returns the floor shadows' boxes by drawing them.
void furnish(Scene& scene, const Walls& room, int side, Canvas& floor) {
  Random& random = scene.random;
  const double span = side % 2 ? room.length : room.width;
  const auto shadow = [&](const Place& place, double depth, double width) {
    const Vector3d a = place(0, -0.5 * width, 0), b = place(depth, 0.5 * width, 0);
    // The floor's canvas has its origin at the corner x = 0, y = 0, its right along +y and down along +x.
    floor.shadow(std::min(a.y(), b.y()), std::min(a.x(), b.x()), std::max(a.y(), b.y()), std::max(a.x(), b.x()), 0.12,
                 0.55);
  };
  const auto decorate = [&](double at, double from, double w) {
    if (random.below(5) == 0) {
      add_clock(scene, on_wall(room, side, at).at(0, 0, from + 0.4), 0.34);
      return;
    }
    const double pw = std::min(w, random.uniform(0.4, 0.9)),
                 ph = std::min(pw * random.uniform(0.7, 1.4), room.height - from - 0.25);
    if (ph < 0.25) return;
    const Place place = on_wall(room, side, at).at(0, 0, from + 0.12 + 0.5 * ph);
    if (random.below(5) == 0) {
      add_picture(scene, place, pw, ph, notice_board(random, pw, ph, 380));
    } else {
      add_picture(scene, place, pw, ph, poster(random, pw, ph, 360), random.below(2) ? 0.03 : 0.004);
    }
  };
  double at = -0.5 * span + 0.55;
  int previous = -1;
  while (at < 0.5 * span - 0.9) {
    int kind = static_cast<int>(random.below(9));
    if (kind == previous) kind = (kind + 1) % 9;
    previous = kind;
    const double left = 0.5 * span - 0.35 - at;
    double w = std::min(left, random.uniform(0.8, 1.5));
    const Place place = on_wall(room, side, at + 0.5 * w);
    switch (kind) {
      case 0:
      case 1: {
        const double height = random.uniform(1.5, 2.2);
        add_bookcase(scene, place, w, height);
        shadow(place, 0.3, w);
        decorate(at + 0.5 * w, height, w);
        break;
      }
      case 2:
        add_desk(scene, place, std::max(w, 1.2));
        w = std::max(w, 1.2);
        shadow(place, 0.7, w);
        decorate(at + 0.5 * w, 1.25, w);
        break;
      case 3: {
        const double height = random.uniform(0.7, 1.2);
        add_cabinet(scene, place, w, height, random.uniform(0.35, 0.5));
        shadow(place, 0.45, w);
        decorate(at + 0.5 * w, height + 0.35, w);
        break;
      }
      case 4:
        w = std::min(left, random.uniform(1.5, 2.1));
        add_sofa(scene, on_wall(room, side, at + 0.5 * w), w);
        shadow(on_wall(room, side, at + 0.5 * w), 0.82, w);
        decorate(at + 0.3 * w, 0.95, 0.5 * w);
        decorate(at + 0.75 * w, 0.95, 0.4 * w);
        break;
      case 5:
        w = 0.8;
        add_boxes(scene, place);
        shadow(on_wall(room, side, at + 0.4), 0.65, 0.6);
        decorate(at + 0.4, 1.2, w);
        break;
      case 6:
        w = std::min(left, 1.4);
        add_window(scene, on_wall(room, side, at + 0.5 * w), w * 0.75, 1.25, 0.95);
        add_radiator(scene, on_wall(room, side, at + 0.5 * w), 0.7 * w);
        shadow(on_wall(room, side, at + 0.5 * w), 0.15, 0.7 * w);
        break;
      case 7:
        w = 0.75;
        if (random.below(2)) {
          add_plant(scene, on_wall(room, side, at + 0.5 * w), random.uniform(1.1, 1.7));
        } else {
          add_floor_lamp(scene, on_wall(room, side, at + 0.5 * w));
        }
        shadow(on_wall(room, side, at + 0.5 * w), 0.5, 0.4);
        decorate(at + 0.5 * w, 0.9, w);
        break;
      default: {
        w = 1.0;
        const Place door_at = on_wall(room, side, at + 0.5 * w);
        const Skin leaf = painted(scene, door(random, 0.88, 2.05, 230));
        scene.add_rect(door_at(0.012, -0.44, 2.05), door_at.turn(0, 0.88, 0), {0, 0, -2.05}, leaf);
        const Skin frame = material(scene, planks(random, 0.5, 0.5, 200, 90, 0.2));
        for (const double s : {-0.48, 0.48}) add_box(scene, door_at.at(0.03, s, 0), 0.06, 0.08, 2.13, BoxSkin(frame));
        add_box(scene, door_at.at(0.03, 0, 2.05), 0.06, 0.88, 0.08, BoxSkin(frame), true);
      }
    }
    at += w + random.uniform(0.08, 0.3);
  }
}

void add_middle(Scene& scene, const Walls& room, Canvas& floor) {
  Random& random = scene.random;
  const Skin wood = material(scene, planks(random, 1.5, 1.5, 220, random.uniform(90, 180), 0.14));
  const Place middle{{0.5 * room.length, 0.5 * room.width, 0}, random.uniform(-0.3, 0.3)};
  // A rug under the table.
  const double cy = 0.5 * room.width, cx = 0.5 * room.length;
  const Canvas rug = carpet(random, 2.0, 1.5, 190, random.uniform(90, 160));
  const Skin rug_skin = painted(scene, rug, 0.12);
  scene.add_rect(middle(-0.75, -1.0, 0.006), middle.turn(0, 2.0, 0), middle.turn(1.5, 0, 0), rug_skin);
  floor.shadow(cy - 0.7, cx - 0.5, cy + 0.7, cx + 0.5, 0.25, 0.35);
  add_table(scene, middle, 0.7, 1.1, 0.72, wood);
  for (const double side : {-1.0, 1.0}) {
    const double y = side * random.uniform(0.12, 0.3);
    add_chair(scene,
              middle.at(-side * 0.62, y, 0, side > 0 ? random.uniform(-0.3, 0.3) : pi + random.uniform(-0.3, 0.3)),
              wood);
  }
  for (int i = 0; i < 5; ++i) {
    const double w = random.uniform(0.14, 0.2);
    BoxSkin book(painted(scene, book_cover(random, w, 0.03, 300)));
    book.top = painted(scene, book_cover(random, w, w * 1.4, 420));
    add_box(scene, middle.at(random.uniform(-0.2, 0.2), -0.4 + 0.2 * i, 0.72, random.uniform(-0.8, 0.8)), w * 1.4, w,
            random.uniform(0.02, 0.08), book);
  }
}

CameraPath tour(const Walls& room, uint64_t seed) {
  Random random(seed);
  // One round in `period` seconds at about half a metre a second, looking to the walls, now ahead, now back.
  const double period = 17, interval = 0.5;
  const double rx = 0.5 * room.length - 1.75, ry = 0.5 * room.width - 1.6, start = random.uniform(0, 2 * pi);
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
  const Walls room{random.uniform(6.0, 7.0), random.uniform(5.0, 5.8), random.uniform(2.5, 2.8)};
  Canvas floor = [&] {
    const double tone = random.uniform(95, 165);
    switch (random.below(3)) {
      case 0:
        return planks(random, room.width, room.length, 130, tone, 0.13);
      case 1:
        return tiles(random, room.width, room.length, 130, tone, 0.3);
      default:
        return carpet(random, room.width, room.length, 130, tone);
    }
  }();
  for (int side = 0; side < 4; ++side) {
    const double span = side % 2 ? room.length : room.width;
    Skin skin = painted(scene, wall_canvas(random, span, room.height), 0.1);
    const Place wall = on_wall(room, side, 0);
    skin.gain = light(wall.turn(1, 0, 0));
    scene.add_rect(wall(0, -0.5 * span, room.height), wall.turn(0, span, 0), {0, 0, -room.height}, skin);
    furnish(scene, room, side, floor);
  }
  add_middle(scene, room, floor);
  floor.darken_edges(0.5, 0.3);
  scene.add_rect({0, 0, 0}, {0, room.width, 0}, {room.length, 0, 0}, painted(scene, floor, 0.12));
  Canvas ceiling = ceiling_panels(random, room.width, room.length, 90, 0.6);
  ceiling.darken_edges(0.6, 0.3);
  scene.add_rect({room.length, 0, room.height}, {0, room.width, 0}, {-room.length, 0, 0}, painted(scene, ceiling, 0.1));
  const Skin lamp = material(scene, plaster(random, 0.5, 0.5, 150, 245), 0.02);
  for (const double x : {0.3, 0.7}) {
    add_box(scene, {{x * room.length, 0.5 * room.width, room.height - 0.08}, 0}, 0.25, 1.2, 0.08, BoxSkin(lamp), true);
  }
  return {std::move(scene), tour(room, hash_seed(seed, 2)), 30, 600, 0.11};
}

}  // namespace covis::synth
