// SPDX-License-Identifier: Apache-2.0
#include "synth/things/street_things.h"

#include "synth/things/furniture.h"
#include "synth/things/materials.h"

namespace covis::synth {
namespace {

constexpr double kTexels = 44;  // texels per metre of facade

Skin plain(Scene& scene, double tone) { return material(scene, plaster(scene.random, 2, 2, 60, tone), 0.2); }

void add_balconies(Scene& scene, const Place& place, double width, double height, double storey) {
  Random& random = scene.random;
  const Skin concrete = plain(scene, random.uniform(110, 190));
  Canvas bars(2, 1, 60, random.uniform(120, 200));
  for (double x = 0.04; x < 2; x += 0.14) bars.rect(x, 0.1, x + 0.06, 1, 45);
  const Skin rail{.texture = scene.add_texture(bars), .metres = 2, .detail = 0.1};
  const double w = random.uniform(1.6, 2.6), y = random.uniform(-0.3, 0.3) * (width - w);
  for (double z = storey; z < height - storey * 0.8; z += storey) {
    add_box(scene, place.at(0.5, y, z), 1.0, w, 0.14, BoxSkin(concrete), Bottom::closed);
    add_box(scene, place.at(0.95, y, z + 0.14), 0.06, w, 0.95, BoxSkin(rail));
    for (const double side : {-0.5, 0.5})
      add_box(scene, place.at(0.5, y + side * (w - 0.06), z + 0.14), 1.0, 0.06, 0.95, BoxSkin(rail));
    if (random.below(2))
      add_foliage(scene, place(0.9, y + random.uniform(-0.6, 0.6), z + 1.2), 0.3, 0.16, 10,
                  scene.add_texture(leaves(random, 0.6, 0.6, 80)));
  }
}

}  // namespace

void add_building(Scene& scene, const Place& place, double width, double depth) {
  Random& random = scene.random;
  const double storey = random.uniform(2.9, 3.5);
  const int storeys = 2 + static_cast<int>(random.below(4));
  const double height = storeys * storey + random.uniform(0.4, 1.0);
  const Front kinds[] = {Front::flats, Front::shop, Front::office, Front::shop, Front::flats, Front::warehouse};
  const Front front = kinds[random.below(6)];
  BoxSkin skin(painted(scene, facade(random, width, height, kTexels, front, storey), 0.2));
  skin.left = skin.right = painted(scene, facade(random, depth, height, 0.6 * kTexels, Front::warehouse, storey), 0.2);
  skin.top = plain(scene, 90);
  add_box(scene, place.at(-0.5 * depth, 0, 0), depth, width, height, skin);
  const Skin stone = plain(scene, random.uniform(120, 200));
  add_box(scene, place.at(0.12, 0, height - 0.35), 0.3, width + 0.1, 0.35, BoxSkin(stone), Bottom::closed);  // cornice
  if (random.below(2)) {  // roof behind it
    const double ridge = height + random.uniform(1.5, 3);
    const Skin tiles_skin = painted(scene, roof(random, width, 3, 30), 0.2);
    scene.add_rect(place(-3, -0.5 * width, ridge), place.turn(0, width, 0), place.turn(3, 0, height - ridge),
                   tiles_skin);
    for (int i = 0; i < 2; ++i) {
      add_box(scene, place.at(-2.2, random.uniform(-0.4, 0.4) * width, height), 0.7, 0.9, ridge - height + 0.7,
              BoxSkin(material(scene, bricks(random, 2, 2, 60, 120), 0.2)));
    }
  }
  if (front == Front::shop) {
    if (random.below(3)) {  // awning
      Canvas stripes(width, 1.3, 40, 210);
      const double stripe = random.uniform(0.3, 0.7), t = random.uniform(30, 140);
      for (double x = 0; x < width; x += 2 * stripe) stripes.rect(x, 0, x + stripe, 1.3, t);
      const Skin cloth = painted(scene, stripes, 0.2);
      const double a = random.uniform(0.7, 0.95) * width;
      scene.add_rect(place(0.02, -0.5 * a, 3.25), place.turn(0, a, 0), place.turn(1.3, 0, -0.5), cloth).two_sided =
          true;
    }
    const double sw = random.uniform(0.7, 1.1), sh = random.uniform(0.7, 1.1);
    BoxSkin sign(stone);
    sign.left = sign.right = painted(scene, shop_sign(random, sw, sh, 110), 0.05);
    add_box(scene, place.at(0.15 + 0.5 * sw, random.uniform(-0.4, 0.4) * width, 3.5), sw, 0.1, sh, sign,
            Bottom::closed);
  } else if (front == Front::flats && random.below(2)) {
    add_balconies(scene, place, width, height, storey);
  } else {
    for (int i = 0; i < 2; ++i) {  // bays projecting from the front
      const double w = random.uniform(1.6, 2.4), d = random.uniform(0.4, 0.9),
                   y = (i - 0.5) * 0.55 * width + random.uniform(-0.4, 0.4), h = random.uniform(0.5, 0.9) * height;
      BoxSkin bay(painted(scene, facade(random, w, h, kTexels, Front::flats, storey), 0.2));
      bay.left = bay.right = painted(scene, plaster(random, d, h, 30, random.uniform(90, 190)), 0.2);
      bay.top = plain(scene, 80);
      add_box(scene, place.at(0.5 * d, y, 0), d, w, h, bay);
    }
  }
  add_box(scene, place.at(0.06, 0.5 * width - 0.2, 0), 0.12, 0.12, height, BoxSkin(plain(scene, 70)));  // drain pipe
}

void add_garden(Scene& scene, const Place& place, double width, double depth, int leaf_texture) {
  Random& random = scene.random;
  const Skin boards = painted(scene, fence(random, width, 1.8, 60), 0.2);
  add_box(scene, place.at(-0.1, 0, 0), 0.1, width, random.uniform(1.1, 1.8), BoxSkin(boards));
  for (int i = 0; i < 3; ++i)
    add_tree(scene, place.at(-random.uniform(2, depth - 2), random.uniform(-0.4, 0.4) * width, 0), leaf_texture);
  BoxSkin back(painted(scene, facade(random, width, 9, 0.7 * kTexels, Front::flats, 3), 0.2));
  add_box(scene, place.at(-depth - 1, 0, 0), 2, width, 9, back);
  for (const double side : {-0.5, 0.5}) {  // hedges along the neighbours
    add_foliage(scene, place(-2.5, side * (width - 1), 1), 1.1, 0.4, 30, leaf_texture);
  }
}

void add_car(Scene& scene, const Place& place) {
  Random& random = scene.random;
  const bool van = random.below(5) == 0;
  const double length = van ? 4.9 : random.uniform(3.8, 4.5), width = van ? 1.95 : 1.75,
               paint = random.below(3) ? random.uniform(30, 235) : 215;
  const double body = van ? 1.05 : 0.78, cabin = van ? 1.0 : 0.6, ground = 0.25;
  const Skin panel = material(scene, plaster(random, 2, 2, 80, paint), 0.05);
  BoxSkin skin(panel);
  skin.left = skin.right = painted(scene, car_side(random, length, body, 90, paint), 0.05);
  skin.front = painted(scene, car_end(random, width, body, 100, paint, CarEnd::front), 0.05);
  skin.back = painted(scene, car_end(random, width, body, 100, paint, CarEnd::back), 0.05);
  add_box(scene, place.at(0, 0, ground), length, width, body, skin);
  // The cabin has four sloping glass panes and a roof.
  const double front = van ? 0.44 : 0.16, back = van ? -0.48 : -0.42, slope = van ? 0.25 : 0.5, inset = 0.14;
  const auto corner = [&](double x, double side, double z) { return place(x, side, ground + body + z); };
  const double x0 = back * length, x1 = front * length, y = 0.5 * width - 0.04, top = y - inset;
  const auto pane = [&](const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
                        double w) {  // top left, bottom left, bottom right, top right
    Canvas glass(w, cabin, 70, 45);
    glass.triangle({0, 0.6 * w, 0}, {0, 0, 0.9 * cabin}, 140, 0.8);
    glass.frame(0, 0, w, cabin, 0.06, paint);
    if (w > 1.8) glass.rect(0.5 * w - 0.05, 0, 0.5 * w + 0.05, cabin, paint);
    if (van && w > 2) glass.rect(0, 0, 0.6 * w, cabin, paint);
    scene.add_polygon({a, b, c, d}, 0.5 * (a + d) - 0.5 * (c - b), c - b, 0.5 * (b + c) - 0.5 * (a + d),
                      painted(scene, glass, 0.05));
  };
  const double l0 = x0 + 0.6 * slope, l1 = x1 - slope;
  pane(corner(l1, -top, cabin), corner(x1, -y, 0), corner(x1, y, 0), corner(l1, top, cabin), 2 * y);
  pane(corner(l0, top, cabin), corner(x0, y, 0), corner(x0, -y, 0), corner(l0, -top, cabin), 2 * y);
  pane(corner(l1, top, cabin), corner(x1, y, 0), corner(x0, y, 0), corner(l0, top, cabin), x1 - x0);
  pane(corner(l0, -top, cabin), corner(x0, -y, 0), corner(x1, -y, 0), corner(l1, -top, cabin), x1 - x0);
  scene.add_polygon({corner(l0, top, cabin), corner(l0, -top, cabin), corner(l1, -top, cabin), corner(l1, top, cabin)},
                    corner(l0, -top, cabin), place.turn(0, 2, 0), place.turn(2, 0, 0), panel);
  const Skin tyre = plain(scene, 30);
  Canvas hub(0.6, 0.6, 90, 30);
  hub.disc(0.3, 0.3, 0.19, 180);
  for (int i = 0; i < 5; ++i)
    hub.line(0.3, 0.3, 0.3 + 0.18 * std::cos(1.2566 * i), 0.3 + 0.18 * std::sin(1.2566 * i), 0.04, 80);
  BoxSkin wheel(tyre);
  wheel.left = wheel.right = painted(scene, hub, 0.05);
  for (const double x : {-0.31, 0.31}) {
    for (const double side : {-0.5, 0.5})
      add_box(scene, place.at(x * length, side * (width - 0.16), 0), 0.6, 0.2, 0.6, wheel);
  }
  // The dark ground below the car.
  Skin shade = plain(scene, 28);
  scene.add_rect(place(-0.5 * length, -0.5 * width, 0.012), place.turn(0, width, 0), place.turn(length, 0, 0), shade);
}

void add_tree(Scene& scene, const Place& place, int leaf_texture) {
  Random& random = scene.random;
  const double trunk = random.uniform(1.8, 2.8), radius = random.uniform(1.0, 1.7), r = random.uniform(0.12, 0.22);
  Canvas bark(2 * 3.14 * r, trunk + 1, 70, random.uniform(60, 110));
  bark.noise(0.06, 0.5, 30, random.next());
  bark.fractal(0.3, 16, 4, 0.8, random.next());
  bark.spots(8, 0.02, 0.08, 30, 0.8, random.next());
  const Skin skin = painted(scene, bark, 0.25);
  add_prism(scene, place, r, 0.6 * r, trunk + 1, 8, skin, skin);
  for (int i = 0; i < 3; ++i) {
    const Vector3d centre = place(random.uniform(-0.5, 0.5) * radius, random.uniform(-0.5, 0.5) * radius,
                                  trunk + radius * (0.6 + 0.45 * i));
    add_foliage(scene, centre, radius * random.uniform(0.75, 1.0), 0.42, 26, leaf_texture);
  }
}

void add_street_furniture(Scene& scene, const Place& place) {
  Random& random = scene.random;
  const Skin metal = plain(scene, random.uniform(50, 130));
  switch (random.below(6)) {
    case 0: {  // lamp post
      add_prism(scene, place, 0.12, 0.06, 5.5, 8, metal, metal);
      add_box(scene, place.at(0.6, 0, 5.4), 1.4, 0.1, 0.1, BoxSkin(metal), Bottom::closed);
      add_box(scene, place.at(1.2, 0, 5.3), 0.5, 0.25, 0.1, BoxSkin(plain(scene, 230)), Bottom::closed);
      break;
    }
    case 1: {  // bin
      Canvas front(1.6, 0.9, 70, random.uniform(50, 120));
      front.rect(0, 0, 1.6, 0.12, 30);
      for (double x = 0.1; x < 1.6; x += 0.4) front.text(x, 0.4, 0.12, made_up_word(random, 2), 225);
      front.fractal(0.4, 10, 5, 0.8, random.next());
      add_prism(scene, place, 0.22, 0.27, 0.9, 10, painted(scene, front, 0.2), metal);
      break;
    }
    case 2:
    case 3: {  // traffic sign
      add_prism(scene, place, 0.035, 0.035, 2.3, 6, metal, metal);
      const double w = random.uniform(0.55, 0.9);
      BoxSkin plate(metal);
      plate.front = plate.back = painted(scene, shop_sign(random, w, w, 120), 0.05);
      add_box(scene, place.at(0.05, 0, 2.0).at(0, 0, 0, random.below(2) ? 1.57 : -1.57), 0.03, w, w, plate,
              Bottom::closed);
      break;
    }
    case 4: {  // letter box or cable cabinet
      const double w = random.uniform(0.5, 1.1), h = random.uniform(0.9, 1.3);
      Canvas front(w, h, 90, random.uniform(60, 180));
      front.rect(0.1 * w, 0.15 * h, 0.9 * w, 0.2 * h, 20);
      front.text(0.12 * w, 0.3 * h, 0.11, made_up_word(random, 4), 235);
      front.frame(0.1 * w, 0.5 * h, 0.9 * w, 0.92 * h, 0.02, 40);
      front.fractal(0.4, 10, 5, 0.8, random.next());
      add_box(scene, place, 0.4, w, h, BoxSkin(painted(scene, front, 0.2)));
      break;
    }
    default: {  // kiosk with posters
      Canvas wrap(4.4, 2.6, 60, random.uniform(90, 190));
      wrap.fractal(1, 10, 6, 0.8, random.next());
      for (double x = 0.1; x < 4; x += 0.9) {
        for (double y = 0.2; y < 2; y += 1.1) {
          wrap.rect(x, y, x + 0.75, y + 0.95, random.uniform(40, 240));
          wrap.text(x + 0.05, y + 0.1, 0.14, made_up_word(random, 4), random.below(2) ? 20 : 240);
          wrap.disc(x + 0.37, y + 0.6, random.uniform(0.1, 0.25), random.uniform(20, 240));
        }
      }
      add_prism(scene, place, 0.7, 0.7, 2.6, 14, painted(scene, wrap, 0.15), metal);
      add_prism(scene, place.at(0, 0, 2.6), 0.85, 0.2, 0.6, 14, metal, metal);
    }
  }
}

}  // namespace covis::synth
