// SPDX-License-Identifier: Apache-2.0
// A long hall of nearly plain walls on which the same few doors, posters and boards are repeated in the same groups.
// The camera walks along it once and looks to both sides: many views look alike, but the camera never returns to a
// place.
#include <array>
#include <numbers>

#include "synth/things/furniture.h"
#include "synth/things/interior.h"
#include "synth/things/materials.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

using std::numbers::pi;

struct Hall {
  double length, width, height;  // extent along x from 0, along y around 0, and height
};

// Paint on a large surface, with barely visible stains.
Canvas weak_paint(Random& random, double w, double h, double tone) {
  Canvas c(w, h, 60, tone);
  c.fractal(1.5, 9, 6, 0.75, random.next());
  c.spots(4, 0.006, 0.03, tone - 25, 0.5, random.next());
  return c;
}

// A group of objects side by side, at the same positions within the group wherever it is placed.
struct Group {
  double width = 0;
  // With the distance of their middles from the group's left end, metres.
  std::vector<std::pair<const Piece*, double>> things;
};

// The objects from which groups are made.
struct Stock {
  std::array<Piece, 3> posters;
  std::array<Piece, 2> doors;
  Piece board;
};

Stock make_stock(Scene& scene) {
  Random& random = scene.random;
  Stock stock;
  for (Piece& piece : stock.posters) {
    const double w = random.uniform(0.55, 0.8), h = w * random.uniform(1.1, 1.4);
    add_picture(scene, {{0, 0, random.uniform(1.45, 1.6)}, 0}, w, h, poster(random, w, h, 360),
                random.below(2) ? 0.03 : 0.004);
    piece = scene.cut(0);
  }
  for (Piece& piece : stock.doors) {
    add_door(scene, {});
    piece = scene.cut(0);
  }
  add_picture(scene, {{0, 0, 1.5}, 0}, 1.1, 0.8, notice_board(random, 1.1, 0.8, 380));
  stock.board = scene.cut(0);
  return stock;
}

std::array<Group, 3> make_groups(Random& random, const Stock& stock) {
  const auto group = [&](std::initializer_list<std::pair<const Piece*, double>> things) {  // with their widths
    Group g;
    for (const auto& [part, width] : things) {
      g.width += random.uniform(0.1, 0.3);
      g.things.emplace_back(part, g.width + 0.5 * width);
      g.width += width;
    }
    return g;
  };
  return {group({{&stock.posters[0], 0.8}, {&stock.doors[0], 1.05}, {&stock.posters[1], 0.8}}),
          group({{&stock.doors[1], 1.05}, {&stock.board, 1.1}}),
          group({{&stock.posters[2], 0.8}, {&stock.doors[0], 1.05}, {&stock.posters[0], 0.8}})};
}

// Wall sections with groups on them, and plain pilasters between the sections.
void add_side(Scene& scene, const std::array<Group, 3>& groups, const Wall& wall, std::vector<Floor>& floors) {
  Random& random = scene.random;
  const Vector2d along = (wall.right - wall.left).normalized();
  size_t pick = random.below(3);
  for (double at = 0; at < wall.length();) {
    const Group& group = groups[pick];
    pick = (pick + 1 + random.below(5) / 3) % groups.size();  // usually the next group
    const double before = random.uniform(0.3, 0.8);
    double end = at + before + group.width + random.uniform(0.3, 0.8);
    const bool fits = end <= wall.length();
    if (!fits) end = wall.length();
    const double tone = random.uniform(120, 190), width = end - at;
    Canvas paint = weak_paint(random, width, wall.height, tone);
    paint.rect(0, wall.height - 0.1, width, wall.height, tone - 60);
    paint.darken_edges(0.4, 0.15);
    Skin skin = painted(scene, paint, 0.1);
    const Place left = wall.at(at);
    skin.gain = light(left.turn(1, 0, 0));
    scene.add_rect(left(0, 0, wall.height), left.turn(0, width, 0), {0, 0, -wall.height}, skin);
    if (fits) {
      for (const auto& [part, x] : group.things) scene.put(*part, wall.at(at + before + x));
    }
    if (end < wall.length()) {
      const double depth = random.uniform(0.12, 0.35), thick = random.uniform(0.2, 0.45);
      const Vector2d p = wall.left + end * along;
      const Place place{{p.x(), p.y(), 0}, left.heading};
      const Skin pilaster = material(scene, weak_paint(random, 1.5, 1.5, random.uniform(100, 200)), 0.12);
      add_box(scene, place.at(0.5 * depth, 0, 0), depth, thick, wall.height, BoxSkin(pilaster));
      add_shadow(floors, place, depth, thick);
    }
    at = end;
  }
}

void add_ceiling(Scene& scene, const Hall& hall) {
  Random& random = scene.random;
  const int pieces = 4;
  for (int i = 0; i < pieces; ++i) {
    const double l = hall.length / pieces, x = (i + 1) * l;
    Canvas paint = weak_paint(random, hall.width, l, random.uniform(170, 210));
    scene.add_rect({x, -0.5 * hall.width, hall.height}, {0, hall.width, 0}, {-l, 0, 0}, painted(scene, paint, 0.1));
  }
  const Skin lamp = material(scene, plaster(random, 0.5, 0.5, 150, 245), 0.02);
  const Skin beam = material(scene, weak_paint(random, 1.5, 1.5, random.uniform(110, 190)), 0.12);
  for (double x = 1; x < hall.length - 0.5; x += random.uniform(1.6, 3.2)) {
    if (random.below(3)) {
      add_box(scene, {{x, random.uniform(-0.4, 0.4), hall.height - 0.08}, 0}, 1.1, 0.22, 0.08, BoxSkin(lamp),
              Bottom::closed);
    } else {
      const double drop = random.uniform(0.15, 0.35);
      add_box(scene, {{x, 0, hall.height - drop}, 0}, 0.2, hall.width, drop, BoxSkin(beam), Bottom::closed);
    }
  }
}

CameraPath walk(const Hall& hall, uint64_t seed) {
  Random random(seed);
  const double speed = 0.85, interval = 0.5;
  const double p1 = random.uniform(0, 2 * pi), p2 = random.uniform(0, 2 * pi);
  const double look = random.uniform(0.45, 0.6), wave = random.uniform(7.5, 10);
  std::vector<CameraPose> control;
  for (double x = 0.6; x < hall.length - 4; x += speed * interval) {
    CameraPose pose;
    pose.position = {x, 0.2 * std::sin(0.8 * x + p1), 1.45 + 0.05 * std::sin(0.5 * x + p2)};
    pose.heading = look * std::sin(2 * pi * x / wave + p1);
    pose.pitch = -0.03 + 0.05 * std::sin(0.9 * x + p2);
    control.push_back(pose);
  }
  return {std::move(control), interval, {.metres = 0.01, .radians = 0.01}, random.next()};
}

}  // namespace

World make_posters(uint64_t seed) {
  Scene scene(seed);
  Random& random = scene.random;
  const Hall hall{random.uniform(25, 31), random.uniform(2.7, 3.3), random.uniform(2.6, 2.9)};
  const double x1 = hall.length, y1 = 0.5 * hall.width;
  const Stock stock = make_stock(scene);
  const std::array<Group, 3> groups = make_groups(random, stock);
  std::vector<Floor> floors;
  for (int i = 0; i < 3; ++i) {
    const double l = x1 / 3;
    Canvas paint = weak_paint(random, hall.width, l, random.uniform(90, 150));
    floors.push_back({{i * l, -y1}, std::move(paint)});
  }
  add_side(scene, groups, {{x1, -y1}, {0, -y1}, hall.height}, floors);
  add_side(scene, groups, {{0, y1}, {x1, y1}, hall.height}, floors);
  for (const Wall& end : {Wall{{0, -y1}, {0, y1}, hall.height}, Wall{{x1, y1}, {x1, -y1}, hall.height}}) {
    const Place place = end.at(0);
    Skin skin = painted(scene, weak_paint(random, hall.width, hall.height, random.uniform(120, 180)), 0.1);
    skin.gain = light(place.turn(1, 0, 0));
    scene.add_rect(place(0, 0, hall.height), place.turn(0, hall.width, 0), {0, 0, -hall.height}, skin);
    scene.put(stock.doors[1], end.at(0.5 * hall.width - 0.5));
    scene.put(stock.posters[2], end.at(0.5 * hall.width + 0.6));
  }
  for (Floor& floor : floors) add_floor(scene, std::move(floor), 0.12);
  add_ceiling(scene, hall);
  CameraPath path = walk(hall, hash_seed(seed, 2));
  const int frames = static_cast<int>(30 * path.period());
  return {std::move(scene), std::move(path), 30, frames, 0.11};
}

}  // namespace covis::synth
