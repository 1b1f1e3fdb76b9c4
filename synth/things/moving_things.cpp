// SPDX-License-Identifier: Apache-2.0
#include "synth/things/moving_things.h"

#include <cmath>
#include <numbers>

#include "synth/things/furniture.h"
#include "synth/things/materials.h"
#include "synth/things/street_things.h"

namespace covis::synth {
namespace {

using std::numbers::pi;

// A person in trousers and a printed shirt, who faces x.
void add_person(Scene& scene) {
  Random& random = scene.random;
  const double legs = random.uniform(0.78, 0.9), torso = random.uniform(0.6, 0.68);
  const Skin trousers = material(scene, fabric(random, 0.6, 0.6, 300, random.uniform(40, 130)));
  const Skin cloth = material(scene, wallpaper(random, 0.8, 0.8, 300, random.uniform(60, 200)));
  const Skin hair = material(scene, fabric(random, 0.4, 0.4, 300, random.uniform(25, 110)));
  for (const double side : {-0.11, 0.11}) add_box(scene, Place().at(0, side, 0), 0.17, 0.18, legs, BoxSkin(trousers));
  BoxSkin shirt(cloth);
  shirt.front = painted(scene, poster(random, 0.42, torso, 300));
  shirt.back = painted(scene, poster(random, 0.42, torso, 300));
  add_box(scene, Place().at(0, 0, legs), 0.24, 0.42, torso, shirt, Bottom::closed);
  for (const double side : {-0.27, 0.27}) {
    add_box(scene, Place().at(0, side, legs - 0.05), 0.12, 0.11, torso + 0.02, BoxSkin(cloth), Bottom::closed);
  }
  add_prism(scene, Place().at(0, 0, legs + torso), 0.06, 0.1, 0.27, 10, hair, hair);
}

void add_book(Scene& scene) {
  Random& random = scene.random;
  BoxSkin skin(painted(scene, book_row(random, 0.2, 0.04, 400)));
  skin.front = painted(scene, book_cover(random, 0.15, 0.21, 600));
  skin.back = painted(scene, book_cover(random, 0.15, 0.21, 600));
  add_box(scene, Place(), 0.03, 0.15, 0.21, skin, Bottom::closed);
}

// The camera's way without the tremor of the hand: the mean over a second.
CameraPose smooth(const CameraPath& path, double seconds) {
  constexpr int kHalf = 5;
  CameraPose mean;
  for (int i = -kHalf; i <= kHalf; ++i) {
    const CameraPose pose = path.at(seconds + 0.1 * i);
    mean.position += pose.position / (2 * kHalf + 1);
    mean.heading += pose.heading / (2 * kHalf + 1);
  }
  return mean;
}

}  // namespace

MovingThings::MovingThings(Scene& scene, Traffic traffic, int count, uint64_t seed)
    : traffic_(traffic), polygons_(scene.polygons.size()), vertices_(scene.vertices.size()) {
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    Thing thing;
    thing.oncoming = i % 2 == 1 && (traffic == Traffic::cars || traffic == Traffic::people_along);
    thing.phase = random.uniform(0, 2 * pi);
    if (traffic == Traffic::cars) {
      add_car(scene, {});
      thing.distance = thing.oncoming ? random.uniform(2, 30) : 1.4 + 1.2 * i + random.uniform(0, 0.6);
      thing.aside = thing.oncoming ? 3.2 : 0;
      thing.swing = 0.15;
      thing.frequency = random.uniform(0.03, 0.08);
    } else if (traffic == Traffic::hands) {
      add_book(scene);
      thing.distance = random.uniform(0.45, 0.6);
      thing.aside = 0;
      thing.swing = random.uniform(0.1, 0.3);
      thing.frequency = random.uniform(0.15, 0.4);
    } else {
      add_person(scene);
      const bool along = traffic == Traffic::people_along;
      thing.distance = thing.oncoming ? random.uniform(1, 15) : along ? 1.6 + 0.6 * i : random.uniform(1.1, 1.7);
      thing.aside = thing.oncoming ? 0.5 : along ? -0.15 : random.uniform(-0.3, 0.3);
      thing.swing = along ? 0.35 : random.uniform(0.3, 0.9);
      thing.frequency = random.uniform(0.08, 0.2);
    }
    thing.piece = scene.cut(polygons_);
    things_.push_back(std::move(thing));
  }
}

Vector3d MovingThings::spot(const Thing& thing, const CameraPath& path, double seconds) const {
  const double swing = thing.swing * std::sin(2 * pi * thing.frequency * seconds + thing.phase);
  if (traffic_ == Traffic::people_around || traffic_ == Traffic::hands) {
    const CameraPose camera = smooth(path, seconds);
    const double angle = camera.heading + thing.aside + swing;
    const Vector3d from = camera.position + thing.distance * Vector3d(std::cos(angle), std::sin(angle), 0);
    const double height = traffic_ == Traffic::hands ? camera.position.z() - 0.25 : 0;
    return {from.x(), from.y(), height};
  }
  const bool cars = traffic_ == Traffic::cars;
  const double at = thing.oncoming ? thing.distance - seconds : seconds + thing.distance + (cars ? swing : 0);
  const Vector3d here = smooth(path, at).position, ahead = smooth(path, at + 0.1).position;
  const Vector3d way = Vector3d(ahead.x() - here.x(), ahead.y() - here.y(), 0).normalized();
  const double aside = thing.aside + (cars ? 0 : swing);
  return {here.x() - aside * way.y(), here.y() + aside * way.x(), 0};
}

void MovingThings::place(const CameraPath& path, double seconds, Scene& scene) const {
  scene.polygons.resize(polygons_);
  scene.vertices.resize(vertices_);
  for (const Thing& thing : things_) {
    const Vector3d at = spot(thing, path, seconds), next = spot(thing, path, seconds + 0.05);
    scene.put(thing.piece, {at, std::atan2(next.y() - at.y(), next.x() - at.x())});
  }
}

}  // namespace covis::synth
