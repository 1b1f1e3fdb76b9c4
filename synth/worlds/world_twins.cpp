// SPDX-License-Identifier: Apache-2.0
// Two identical rooms, with a passage between them and a short one at either end. The camera walks through both on the
// same path: the second room looks like the first, but the camera never returns to a place.
#include <numbers>

#include "synth/things/furniture.h"
#include "synth/things/interior.h"
#include "synth/things/materials.h"
#include "synth/things/table_group.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

using std::numbers::pi;

constexpr double kOpening = 1.2, kDoor = 2.1;  // metres: width and height of the openings between room and passage
constexpr double kPassage = 1.9;               // width of the passages

struct Plan {
  double length, width, height;    // size of a room, which extends from x = 0 and y = 0
  double passage, passage_height;  // length from one room to the next, and height
  double end_passage;              // length of the passages at the ends
  double side;                     // +1 or -1: side of y on which the table stands
  double spacing() const { return length + passage; }
};

// Adds a wall with an opening in its middle: the parts to its left and right, and above.
struct OpenWall {
  Wall left, right;
};

OpenWall add_open_wall(Scene& scene, const Wall& wall) {
  Random& random = scene.random;
  const Vector2d middle = 0.5 * (wall.left + wall.right), along = (wall.right - wall.left).normalized();
  const OpenWall parts{{wall.left, middle - 0.5 * kOpening * along, wall.height},
                       {middle + 0.5 * kOpening * along, wall.right, wall.height}};
  add_wall_surface(scene, parts.left);
  add_wall_surface(scene, parts.right);
  const double rise = wall.height - kDoor;
  const Place place = wall.at(0.5 * (wall.length() - kOpening));
  Skin skin = painted(scene, wallpaper(random, kOpening, rise, 130, random.uniform(130, 185)), 0.2);
  skin.gain = light(place.turn(1, 0, 0));
  scene.add_rect(place(0, 0, wall.height), place.turn(0, kOpening, 0), {0, 0, -rise}, skin);
  return parts;
}

// The frame of the opening at x, seen from both sides.
void add_frame(Scene& scene, const Plan& plan, double x) {
  Random& random = scene.random;
  const Skin wood = material(scene, planks(random, 0.8, 0.8, 200, random.uniform(60, 190), 0.1));
  const double depth = 0.24, bar = 0.1, y = 0.5 * plan.width;
  for (const double side : {-0.5, 0.5}) {
    add_box(scene, {{x, y + side * (kOpening + bar), 0}, 0}, depth, bar, kDoor + bar, BoxSkin(wood));
  }
  add_box(scene, {{x, y, kDoor}, 0}, depth, kOpening, bar, BoxSkin(wood), Bottom::closed);
}

void add_ceiling(Scene& scene, double x0, double x1, double y0, double y1, double height, double panel) {
  Canvas ceiling = ceiling_panels(scene.random, y1 - y0, x1 - x0, 90, panel);
  ceiling.darken_edges(0.6, 0.3);
  scene.add_rect({x1, y0, height}, {0, y1 - y0, 0}, {x0 - x1, 0, 0}, painted(scene, ceiling, 0.1));
}

Piece make_twin(Scene& scene, const Plan& plan) {
  Random& random = scene.random;
  const double length = plan.length, width = plan.width, height = plan.height;
  const std::vector<Kind> kinds{Kind::bookcase, Kind::desk,     Kind::cabinet,  Kind::sofa, Kind::boxes,
                                Kind::window,   Kind::greenery, Kind::bookcase, Kind::door};
  std::vector<Floor> floors;
  floors.push_back({{0, 0}, floor_canvas(random, width, length)});
  for (const Wall& wall : {Wall{{0, width}, {length, width}, height}, Wall{{length, 0}, {0, 0}, height}}) {
    add_wall_surface(scene, wall);
    furnish(scene, wall, floors, kinds, 0.5, 0.4);
  }
  for (const Wall& wall : {Wall{{0, 0}, {0, width}, height}, Wall{{length, width}, {length, 0}, height}}) {
    const OpenWall parts = add_open_wall(scene, wall);
    // The sides of the furniture along the long walls stand in the corners.
    furnish(scene, parts.left, floors, {Kind::cabinet, Kind::pictures, Kind::bookcase}, 0.9, 0.15);
    furnish(scene, parts.right, floors, {Kind::pictures, Kind::bookcase, Kind::boxes}, 0.15, 0.9);
  }
  add_frame(scene, plan, 0);
  add_frame(scene, plan, length);
  add_table_group(scene, {0.5 * length, 0.5 * width + 0.75 * plan.side}, floors);
  floors[0].canvas.darken_edges(0.5, 0.3);
  add_floor(scene, floors[0], 0.16);
  add_ceiling(scene, 0, length, 0, width, height, 0.6);
  const Skin lamp = material(scene, plaster(random, 0.5, 0.5, 150, 245), 0.02);
  for (const double x : {0.3, 0.7}) {
    add_box(scene, {{x * length, 0.5 * width, height - 0.08}, 0}, 0.25, 1.2, 0.08, BoxSkin(lamp), Bottom::closed);
  }
  return scene.cut(0);
}

// Adds a passage from x0 to x1. An end is open where there is a room beyond.
enum class End { open, closed };
void add_passage(Scene& scene, const Plan& plan, double x0, double x1, End first, End last) {
  Random& random = scene.random;
  const double y0 = 0.5 * (plan.width - kPassage), y1 = 0.5 * (plan.width + kPassage), height = plan.passage_height;
  std::vector<Floor> floors;
  floors.push_back({{x0, y0}, floor_canvas(random, kPassage, x1 - x0)});
  for (const Wall& wall : {Wall{{x1, y0}, {x0, y0}, height}, Wall{{x0, y1}, {x1, y1}, height}}) {
    add_wall_surface(scene, wall);
    furnish(scene, wall, floors, {Kind::pictures, Kind::pillar, Kind::door}, 0.25, 0.25);
  }
  const auto add_end = [&](const Wall& wall, End end) {
    if (end == End::open) {
      add_open_wall(scene, wall);
    } else {
      add_wall_surface(scene, wall);
      furnish(scene, wall, floors, {Kind::cabinet, Kind::pictures}, 0.3, 0.3);
    }
  };
  add_end({{x0, y0}, {x0, y1}, height}, first);
  add_end({{x1, y1}, {x1, y0}, height}, last);
  floors[0].canvas.darken_edges(0.4, 0.2);
  add_floor(scene, floors[0], 0.16);
  add_ceiling(scene, x0, x1, y0, y1, height, random.uniform(0.4, 0.8));
  const Skin lamp = material(scene, plaster(random, 0.5, 0.5, 150, 245), 0.02);
  add_box(scene, {{0.5 * (x0 + x1), 0.5 * plan.width, height - 0.07}, 0}, 0.8, 0.3, 0.07, BoxSkin(lamp),
          Bottom::closed);
}

// The path from just inside the first room to just before the end of the second, past the tables at three quarters of a
// metre per second. It is a function of the place alone, so that both rooms are walked in the same way.
CameraPath walk(const Plan& plan, uint64_t seed) {
  Random random(seed);
  const double speed = 0.72, interval = 0.5;
  const double bow = -plan.side * random.uniform(0.75, 0.95);
  const double look = (random.below(2) ? 1 : -1) * random.uniform(0.35, 0.55), look_passage = random.uniform(-0.2, 0.2);
  const double p1 = random.uniform(0, 2 * pi);
  std::vector<CameraPose> control;
  for (double x = 0.4; x < plan.spacing() + plan.length - 0.7; x += speed * interval) {
    const double local = x < plan.spacing() ? x : x - plan.spacing();
    CameraPose pose;
    pose.position = {x, 0.5 * plan.width, 1.4};
    if (local < plan.length) {
      const double a = 2 * pi * local / plan.length;
      pose.position.y() += 0.5 * bow * (1 - std::cos(a));
      pose.position.z() += 0.08 * std::sin(a);
      pose.heading = std::atan(bow * pi / plan.length * std::sin(a)) + look * std::sin(a);
      pose.pitch = -0.1 * std::sin(0.5 * a) + 0.07 * std::sin(1.5 * a + p1) * std::sin(0.5 * a);
    } else {
      pose.heading = look_passage * std::sin(2 * pi * (local - plan.length) / plan.passage);
    }
    control.push_back(pose);
  }
  return {std::move(control), interval, {.metres = 0.012, .radians = 0.012}, random.next()};
}

}  // namespace

World make_twins(uint64_t seed) {
  Scene scene(seed);
  Random& random = scene.random;
  const Plan plan{.length = random.uniform(6.6, 7.6),
                  .width = random.uniform(5.6, 6.3),
                  .height = random.uniform(2.5, 2.8),
                  .passage = random.uniform(3.6, 5.2),
                  .passage_height = random.uniform(2.3, 2.45),
                  .end_passage = random.uniform(2.0, 2.6),
                  .side = random.below(2) ? 1.0 : -1.0};
  const Piece room = make_twin(scene, plan);
  scene.put(room, {});
  scene.put(room, {{plan.spacing(), 0, 0}, 0});
  const double end = plan.spacing() + plan.length;
  add_passage(scene, plan, -plan.end_passage, 0, End::closed, End::open);
  add_passage(scene, plan, plan.length, plan.spacing(), End::open, End::open);
  add_passage(scene, plan, end, end + plan.end_passage, End::open, End::closed);
  CameraPath path = walk(plan, hash_seed(seed, 2));
  const int frames = static_cast<int>(30 * path.period());
  return {std::move(scene), std::move(path), 30, frames, 0.11};
}

}  // namespace covis::synth
