// SPDX-License-Identifier: Apache-2.0
#include "synth/things/interior.h"

#include <algorithm>
#include <cmath>

#include "synth/things/furniture.h"
#include "synth/things/materials.h"

namespace covis::synth {

Place Wall::at(double along) const {
  const Vector2d r = (right - left).normalized(), p = left + along * r;
  return {{p.x(), p.y(), 0}, std::atan2(-r.x(), r.y())};
}

void add_shadow(std::vector<Floor>& floors, const Place& place, double depth, double width) {
  const Vector3d a = place(0, -0.5 * width, 0), b = place(depth, 0.5 * width, 0);
  for (Floor& floor : floors) {
    floor.canvas.shadow(std::min(a.y(), b.y()) - floor.low.y(), std::min(a.x(), b.x()) - floor.low.x(),
                        std::max(a.y(), b.y()) - floor.low.y(), std::max(a.x(), b.x()) - floor.low.x(), 0.12, 0.55);
  }
}

void add_floor(Scene& scene, Floor floor, double detail) {
  const double w = floor.canvas.width(), h = floor.canvas.height();
  scene.add_rect({floor.low.x(), floor.low.y(), 0}, {0, w, 0}, {h, 0, 0}, painted(scene, floor.canvas, detail));
}

Canvas floor_canvas(Random& random, double width, double length) {
  const double tone = random.uniform(95, 165);
  switch (random.below(3)) {
    case 0:
      return planks(random, width, length, 130, tone, random.uniform(0.09, 0.16));
    case 1:
      return tiles(random, width, length, 130, tone, random.uniform(0.2, 0.4));
    default:
      return carpet(random, width, length, 130, tone);
  }
}

void add_wall_surface(Scene& scene, const Wall& wall) {
  Random& random = scene.random;
  const double w = wall.length(), h = wall.height, tone = random.uniform(130, 185);
  Canvas c = [&] {
    switch (random.below(5)) {
      case 0:
        return bricks(random, w, h, 140, tone - 25);
      case 1:
        return plaster(random, w, h, 130, tone);
      case 2:
        return tiles(random, w, h, 130, tone + 10, random.uniform(0.15, 0.3));
      default:
        return wallpaper(random, w, h, 130, tone);
    }
  }();
  if (random.below(2)) {  // wainscot boards, with a rail
    const double top = h - random.uniform(0.8, 1.1), boards = random.uniform(0.1, 0.3),
                 t = tone - random.uniform(20, 60);
    for (double x = 0; x < w; x += boards) {
      c.rect(x, top, x + boards, h, t + random.uniform(-14, 14), 0.85);
      c.line(x, top, x, h, 0.008, t - 45);
    }
    c.rect(0, top - 0.05, w, top, t - 30);
    c.line(0, top - 0.05, w, top - 0.05, 0.01, t + 50);
  }
  c.fractal(0.3, 7, 6, 0.9, random.next());  // wear
  c.rect(0, h - 0.12, w, h, tone - 80);      // skirting board
  c.line(0, h - 0.12, w, h - 0.12, 0.01, tone + 30);
  c.darken_edges(0.5, 0.22);
  Skin skin = painted(scene, c, 0.2);
  const Place place = wall.at(0);
  skin.gain = light(place.turn(1, 0, 0));
  scene.add_rect(place(0, 0, h), place.turn(0, w, 0), {0, 0, -h}, skin);
}

// The view lies in the wall's plane; frame, sill and curtains stand out from it.
void add_window(Scene& scene, const Place& wall, double width, double height, double sill) {
  Random& random = scene.random;
  const Skin frame = material(scene, plaster(random, 0.5, 0.5, 200, 220));
  const double bar = 0.06;
  add_box(scene, wall.at(0.06, 0, sill - 0.04), 0.26, width + 0.2, 0.04, BoxSkin(frame), Bottom::closed);
  for (int i = 0; i <= 2; ++i) {
    add_box(scene, wall.at(0.03, (i - 1) * 0.5 * (width - bar), sill), 0.06, bar, height, BoxSkin(frame));
  }
  for (const double z : {0.0, 0.6 * height, height - bar}) {
    add_box(scene, wall.at(0.028, 0, sill + z), 0.055, width, bar, BoxSkin(frame), Bottom::closed);
  }
  Skin view = painted(scene, view_outside(random, width, height, 240));
  view.gain = 1.1;
  scene.add_rect(wall(0.004, -0.5 * width, sill + height), wall.turn(0, width, 0), {0, 0, -height}, view).window = true;
  const Skin cloth = material(scene, fabric(random, 0.7, 1.5, 150, random.uniform(90, 200)));
  for (const double side : {-1.0, 1.0}) {  // curtains, in folds
    for (int k = 0; k < 4; ++k) {
      add_box(scene, wall.at(0.1 + 0.03 * (k % 2), side * (0.5 * width + 0.02 + 0.08 * k), sill - 0.3), 0.06, 0.085,
              height + 0.5, BoxSkin(cloth));
    }
  }
}

void add_door(Scene& scene, const Place& wall) {
  Random& random = scene.random;
  const double height = 2.05, width = 0.88;
  const Skin leaf = painted(scene, door(random, width, height, 230), 0.14);
  scene.add_rect(wall(0.012, -0.5 * width, height), wall.turn(0, width, 0), {0, 0, -height}, leaf);
  const Skin frame = material(scene, planks(random, 0.5, 0.5, 200, random.uniform(60, 190), 0.2));
  for (const double side : {-0.48, 0.48})
    add_box(scene, wall.at(0.04, side, 0), 0.08, 0.08, height + 0.08, BoxSkin(frame));
  add_box(scene, wall.at(0.04, 0, height), 0.08, width, 0.08, BoxSkin(frame), Bottom::closed);
}

void add_wall_piece(Scene& scene, const Place& wall, double bottom, double top, double width) {
  Random& random = scene.random;
  if (top - bottom < 0.3 || width < 0.25) return;
  if (random.below(7) == 0 && top - bottom > 0.5) {
    add_clock(scene, wall.at(0, 0, bottom + 0.3), 0.34);
    return;
  }
  const double w = std::min(width, random.uniform(0.45, 1.0));
  const double h = std::min(w * random.uniform(0.7, 1.4), top - bottom);
  const Place place = wall.at(0, 0, 0.5 * (bottom + top) + random.uniform(-0.5, 0.5) * (top - bottom - h));
  if (random.below(4) == 0) {
    add_picture(scene, place, w, h, notice_board(random, w, h, 380));
  } else {
    add_picture(scene, place, w, h, poster(random, w, h, 360), random.below(2) ? 0.03 : 0.004);
  }
}

namespace {

void add_pillar(Scene& scene, const Place& place, double height) {
  Random& random = scene.random;
  const double depth = random.uniform(0.15, 0.3), width = random.uniform(0.3, 0.5), tone = random.uniform(110, 190);
  BoxSkin skin(material(
      scene, random.below(2) ? bricks(random, 1.0, 1.0, 180, tone) : plaster(random, 1.0, 1.0, 160, tone), 0.2));
  add_box(scene, place.at(0.5 * depth, 0, 0), depth, width, height, skin);
  add_box(scene, place.at(0.5 * depth, 0, 0), depth + 0.06, width + 0.06, 0.15, skin);
  if (random.below(3)) add_wall_piece(scene, place.at(depth, 0, 0), 1.1, 1.9, width - 0.04);
}

void add_bench(Scene& scene, const Place& place, double width) {
  Random& random = scene.random;
  const Skin wood = material(scene, planks(random, 1.2, 1.2, 200, random.uniform(80, 170), 0.1));
  for (const double side : {-0.5 * width + 0.1, 0.5 * width - 0.1})
    add_box(scene, place.at(0.22, side, 0), 0.36, 0.05, 0.42, BoxSkin(wood));
  for (const double x : {0.08, 0.2, 0.32})
    add_box(scene, place.at(x, 0, 0.42), 0.1, width, 0.03, BoxSkin(wood), Bottom::closed);
  if (random.below(2)) add_boxes(scene, place.at(-0.12, 0.2 * width, 0.45));
}

// Adds a vending machine or copier: a tall box with a busy front.
void add_machine(Scene& scene, const Place& place) {
  Random& random = scene.random;
  const double w = random.uniform(0.7, 0.9), h = random.uniform(1.7, 1.95), d = 0.5;
  Canvas front(w, h, 300, random.uniform(50, 190));
  front.fractal(0.3, 10, 5, 0.8, random.next());
  front.rect(0.06, 0.08, w * 0.72, h * 0.68, 25);
  for (double y = 0.1; y < h * 0.6; y += 0.2) {
    for (double x = 0.08; x < w * 0.66; x += 0.085) {
      const double t = random.uniform(60, 240);
      front.rect(x, y + random.uniform(0.01, 0.05), x + 0.065, y + 0.16, t);
      front.rect(x + 0.01, y + 0.08, x + 0.055, y + 0.12, t > 128 ? 40 : 220);
    }
    front.rect(0.06, y + 0.165, w * 0.72, y + 0.18, 190);
  }
  front.text(0.1, h * 0.72, 0.12, made_up_word(random, 5), 235);
  front.rect(0.1, h * 0.85, w * 0.6, h * 0.94, 20);
  for (int i = 0; i < 12; ++i) front.disc(w * 0.79 + 0.05 * (i % 3), h * 0.3 + 0.05 * (i / 3), 0.017, 220);
  front.rect(w * 0.76, h * 0.2, w * 0.94, h * 0.25, 235);
  BoxSkin skin(painted(scene, front, 0.08),
               material(scene, plaster(random, 1.0, 1.0, 160, random.uniform(60, 180)), 0.2));
  add_box(scene, place.at(0.5 * d, 0, 0), d, w, h, skin);
}

void add_lockers(Scene& scene, const Place& place, double width) {
  Random& random = scene.random;
  const double height = 1.8, depth = 0.4, tone = random.uniform(90, 190);
  Canvas front(width, height, 240, tone);
  front.fractal(0.5, 10, 6, 0.8, random.next());
  const int columns = std::max(2, static_cast<int>(width / 0.3)), rows = 1 + static_cast<int>(random.below(3));
  for (int r = 0; r < rows; ++r) {
    for (int k = 0; k < columns; ++k) {
      const double x = width * k / columns, y = height * r / rows, w = width / columns, h = height / rows;
      front.rect(x, y, x + w, y + h, tone + random.uniform(-14, 14), 0.6);
      front.frame(x + 0.006, y + 0.006, x + w - 0.006, y + h - 0.006, 0.008, tone - 70);
      for (int s = 0; s < 5; ++s)
        front.line(x + 0.25 * w, y + 0.06 + 0.022 * s, x + 0.75 * w, y + 0.06 + 0.022 * s, 0.009, 25);
      front.text(x + 0.3 * w, y + 0.2, 0.04, std::to_string(10 + random.below(89)), 25);
      front.rect(x + 0.8 * w, y + 0.5 * h, x + 0.88 * w, y + 0.5 * h + 0.08, 220);
      if (random.below(3) == 0)
        front.rect(x + 0.2 * w, y + 0.55 * h, x + 0.7 * w, y + 0.55 * h + 0.1, random.uniform(20, 240));
      if (random.below(3) == 0) front.disc(x + 0.5 * w, y + 0.8 * h, 0.04, random.uniform(20, 240));
    }
  }
  add_box(scene, place.at(0.5 * depth, 0, 0), depth, width, height,
          BoxSkin(painted(scene, front, 0.1), material(scene, plaster(random, 1, 1, 150, tone), 0.2)));
}

// Adds one object at the wall; returns the width it takes.
double add_kind(Scene& scene, const Wall& wall, std::vector<Floor>& floors, Kind kind, double at, double left) {
  Random& random = scene.random;
  const double top = wall.height - 0.2;
  double w = std::min(left, random.uniform(0.8, 1.5));
  const auto middle = [&] { return wall.at(at + 0.5 * w); };
  switch (kind) {
    case Kind::bookcase: {
      const double height = random.uniform(1.5, 2.2);
      add_bookcase(scene, middle(), w, height);
      add_shadow(floors, middle(), 0.3, w);
      add_wall_piece(scene, middle(), height + 0.05, top, w);
      break;
    }
    case Kind::desk:
      w = std::max(w, 1.2);
      add_desk(scene, middle(), w);
      add_shadow(floors, middle(), 0.7, w);
      add_wall_piece(scene, middle(), 1.3, top, w);
      break;
    case Kind::cabinet: {
      const double height = random.uniform(0.7, 1.2), depth = random.uniform(0.3, 0.45);
      add_cabinet(scene, middle(), w, height, depth);
      add_shadow(floors, middle(), depth, w);
      add_wall_piece(scene, middle(), height + 0.35, top, w);
      break;
    }
    case Kind::sofa:
      w = std::min(left, random.uniform(1.5, 2.1));
      add_sofa(scene, middle(), w);
      add_shadow(floors, middle(), 0.82, w);
      add_wall_piece(scene, wall.at(at + 0.27 * w), 1.0, top, 0.5 * w);
      add_wall_piece(scene, wall.at(at + 0.75 * w), 1.0, top, 0.4 * w);
      break;
    case Kind::boxes:
      w = 0.8;
      add_boxes(scene, middle());
      add_shadow(floors, middle(), 0.65, 0.6);
      add_wall_piece(scene, middle(), 1.3, top, w);
      break;
    case Kind::window:
      w = std::min(left, 1.5);
      add_window(scene, middle(), w * 0.7, 1.25, 0.95);
      add_radiator(scene, middle(), 0.7 * w);
      add_shadow(floors, middle(), 0.15, 0.7 * w);
      break;
    case Kind::greenery:
      w = 0.75;
      if (random.below(3)) {
        add_plant(scene, middle(), random.uniform(1.1, 1.7));
      } else {
        add_floor_lamp(scene, middle());
      }
      add_shadow(floors, middle(), 0.5, 0.4);
      add_wall_piece(scene, middle(), 0.9, top, w);
      break;
    case Kind::door:
      w = 1.05;
      add_door(scene, middle());
      break;
    case Kind::pictures:
      add_wall_piece(scene, wall.at(at + 0.3 * w), 1.0, top, 0.55 * w);
      add_wall_piece(scene, wall.at(at + 0.8 * w), 0.8, top, 0.38 * w);
      add_wall_piece(scene, wall.at(at + 0.5 * w), 0.25, 0.75, 0.6 * w);
      break;
    case Kind::pillar:
      w = 0.5;
      add_pillar(scene, middle(), wall.height);
      add_shadow(floors, middle(), 0.25, 0.4);
      break;
    case Kind::bench:
      add_bench(scene, middle(), w);
      add_shadow(floors, middle(), 0.4, w);
      add_wall_piece(scene, middle(), 1.0, top, w);
      break;
    case Kind::machine:
      w = 1.0;
      add_machine(scene, middle());
      add_shadow(floors, middle(), 0.5, 0.85);
      break;
    case Kind::lockers:
      add_lockers(scene, middle(), w);
      add_shadow(floors, middle(), 0.4, w);
      add_wall_piece(scene, middle(), 1.95, wall.height - 0.05, w);
      break;
  }
  return w;
}

}  // namespace

void furnish(Scene& scene, const Wall& wall, std::vector<Floor>& floors, const std::vector<Kind>& kinds,
             double margin_left, double margin_right) {
  Random& random = scene.random;
  const double end = wall.length() - margin_right;
  size_t previous = kinds.size();
  for (double at = margin_left; end - at > 0.7;) {
    size_t pick = random.below(static_cast<uint32_t>(kinds.size()));
    if (pick == previous) pick = (pick + 1) % kinds.size();
    previous = pick;
    at += add_kind(scene, wall, floors, kinds[pick], at, end - at) + random.uniform(0.06, 0.3);
  }
}

}  // namespace covis::synth
