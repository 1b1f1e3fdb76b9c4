// SPDX-License-Identifier: Apache-2.0
#include "synth/things/furniture.h"

#include <Eigen/Geometry>
#include <numbers>

#include "synth/things/materials.h"

namespace covis::synth {

Skin painted(Scene& scene, const Canvas& canvas, double detail) {
  return {.texture = scene.add_texture(canvas), .detail = detail};
}

Skin material(Scene& scene, const Canvas& canvas, double detail) {
  return {.texture = scene.add_texture(canvas), .metres = canvas.width(), .detail = detail};
}

void add_bookcase(Scene& scene, const Place& place, double width, double height) {
  Random& random = scene.random;
  const double depth = 0.3, board = 0.022;
  const Skin wood = material(scene, planks(random, 1.2, 1.2, 220, random.uniform(70, 185), 0.4));
  for (const double side : {-0.5 * (width - board), 0.5 * (width - board)}) {
    add_box(scene, place.at(0.5 * depth, side, 0), depth, board, height, BoxSkin(wood));
  }
  Skin back = wood;
  back.gain = 0.5;
  scene.add_rect(place(0.01, -0.5 * width, height), place.turn(0, width, 0), {0, 0, -height}, back);
  const int shelves = static_cast<int>(height / 0.36);
  const double step = height / shelves;
  for (int i = 0; i <= shelves; ++i) {
    const double z = std::min(i * step, height - board);
    add_box(scene, place.at(0.5 * depth, 0, z), depth, width - 2 * board, board, BoxSkin(wood), Bottom::closed);
    if (i == shelves) break;
    double y = -0.5 * width + board;
    const double end = 0.5 * width - board;
    while (end - y > 0.1) {  // groups of books of different depths, with an ornament in some gaps
      const double w = std::min(end - y, random.uniform(0.14, 0.42)), d = random.uniform(0.16, 0.27),
                   h = step - board - random.uniform(0.02, 0.1);
      const uint32_t kind = random.below(8);
      if (kind == 0) {
        add_prism(scene, place.at(0.15, y + 0.5 * w, z + board), 0.05, 0.07, h * 0.7, 10,
                  painted(scene, label(random, 0.35, h * 0.7, 400)), wood);
      } else if (kind == 1) {
        add_box(scene, place.at(0.14, y + 0.5 * w, z + board), 0.2, w * 0.8, h * 0.6,
                BoxSkin(painted(scene, label(random, w * 0.8, h * 0.6, 420)), wood));
      } else {
        Skin paper = painted(scene, book_row(random, w, d, 200));
        paper.gain = 0.7;
        BoxSkin skin(paper);
        skin.front = painted(scene, book_row(random, w, h, 420));
        add_box(scene, place.at(0.02 + 0.5 * d, y + 0.5 * w, z + board), d, w, h, skin);
      }
      y += w + (random.below(3) == 0 ? random.uniform(0.02, 0.12) : 0.004);
    }
  }
}

void add_table(Scene& scene, const Place& place, double depth, double width, double height, const Skin& wood) {
  const double top = 0.035, leg = 0.055;
  add_box(scene, place.at(0, 0, height - top), depth, width, top, BoxSkin(wood), Bottom::closed);
  for (const double x : {-0.5 * depth + leg, 0.5 * depth - leg}) {
    for (const double y : {-0.5 * width + leg, 0.5 * width - leg}) {
      add_box(scene, place.at(x, y, 0), leg, leg, height - top, BoxSkin(wood));
    }
  }
}

void add_chair(Scene& scene, const Place& place, const Skin& wood) {
  Random& random = scene.random;
  const Skin cushion = material(scene, fabric(random, 0.6, 0.6, 260, random.uniform(60, 190)));
  for (const double x : {-0.19, 0.19}) {
    for (const double y : {-0.19, 0.19})
      add_box(scene, place.at(x, y, 0), 0.035, 0.035, x < 0 ? 0.95 : 0.45, BoxSkin(wood));
  }
  add_box(scene, place.at(0, 0, 0.43), 0.43, 0.43, 0.05, BoxSkin(cushion), Bottom::closed);
  for (const double z : {0.55, 0.68, 0.81})
    add_box(scene, place.at(-0.19, 0, z), 0.02, 0.36, 0.07, BoxSkin(wood), Bottom::closed);
}

void add_desk(Scene& scene, const Place& place, double width) {
  Random& random = scene.random;
  const Skin wood = material(scene, planks(random, 1.4, 1.4, 240, random.uniform(110, 190), 0.7));
  const double depth = 0.68, height = 0.74;
  add_table(scene, place.at(0.5 * depth + 0.02, 0, 0), depth, width, height, wood);
  const double dw = 0.4;
  add_box(scene, place.at(0.36, 0.5 * width - 0.3, 0), 0.56, dw, 0.6,
          BoxSkin(painted(scene, drawers(random, dw, 0.6, 260, 1, 3)), wood));
  const Skin black = material(scene, plaster(random, 0.5, 0.5, 200, 45));
  for (int i = 0; i < (width > 1.5 ? 2 : 1); ++i) {  // monitors
    const Place monitor = place.at(0.22, -0.25 * width + 0.62 * i, height, random.uniform(-0.25, 0.25));
    add_box(scene, monitor, 0.16, 0.24, 0.015, BoxSkin(black));
    add_box(scene, monitor.at(-0.03, 0, 0.01), 0.03, 0.05, 0.2, BoxSkin(black));
    add_box(scene, monitor.at(0, 0, 0.1), 0.035, 0.54, 0.33,
            BoxSkin(painted(scene, screen(random, 0.54, 0.33, 520), 0.02), black), Bottom::closed);
  }
  BoxSkin keys(black);
  keys.top = painted(scene, keyboard(random, 0.44, 0.15, 700), 0.02);
  add_box(scene, place.at(0.47, -0.2 * width, height), 0.15, 0.44, 0.02, keys);
  for (int i = 0; i < 3; ++i) {  // books and papers
    const double w = random.uniform(0.15, 0.21), d = w * 1.4;
    BoxSkin book(painted(scene, book_cover(random, d, 0.03, 300)));
    book.top = painted(scene, book_cover(random, w, d, 450));
    add_box(scene,
            place.at(random.uniform(0.2, 0.5), random.uniform(0.1, 0.35) * width, height + 0.001 * i,
                     random.uniform(-0.7, 0.7)),
            d, w, random.uniform(0.015, 0.06), book);
  }
  const Skin mug = painted(scene, label(random, 0.26, 0.1, 500));
  add_prism(scene, place.at(0.5, 0.12, height), 0.04, 0.042, 0.1, 12, mug, black);
}

void add_cabinet(Scene& scene, const Place& place, double width, double height, double depth) {
  Random& random = scene.random;
  const Skin front = painted(scene, drawers(random, width, height, 220, 1 + static_cast<int>(random.below(3)),
                                            2 + static_cast<int>(random.below(3))));
  const Skin wood = material(scene, planks(random, 1.2, 1.2, 200, random.uniform(80, 180), 0.6));
  add_box(scene, place.at(0.5 * depth, 0, 0), depth, width, height, BoxSkin(front, wood));
  add_box(scene, place.at(0.5 * depth + 0.01, 0, height), depth + 0.04, width + 0.04, 0.025, BoxSkin(wood),
          Bottom::closed);
  double y = -0.4 * width;
  while (y < 0.4 * width) {  // objects on top
    const double w = random.uniform(0.1, 0.24), h = random.uniform(0.1, 0.3);
    const Place at = place.at(random.uniform(0.35, 0.65) * depth, y, height + 0.025, random.uniform(-0.5, 0.5));
    if (random.below(3) == 0) {
      const Skin vase = painted(scene, wallpaper(random, 0.5, h, 300, random.uniform(60, 200)));
      add_prism(scene, at, 0.3 * w, 0.45 * w, h, 12, vase, vase);
      if (random.below(2))
        add_foliage(scene, at(0, 0, h + 0.1), 0.14, 0.07, 24, scene.add_texture(leaves(random, 0.3, 0.3, 220)));
    } else {
      BoxSkin box(painted(scene, book_cover(random, w, h, 380)));
      add_box(scene, at, random.uniform(0.04, 0.16), w, h, box);
    }
    y += w + random.uniform(0.05, 0.3);
  }
}

void add_sofa(Scene& scene, const Place& place, double width) {
  Random& random = scene.random;
  const Skin cloth = material(scene, fabric(random, 1.3, 1.3, 190, random.uniform(60, 180)));
  add_box(scene, place.at(0.42, 0, 0.05), 0.8, width, 0.34, BoxSkin(cloth));
  add_box(scene, place.at(0.13, 0, 0.05), 0.24, width, 0.78, BoxSkin(cloth));
  for (const double side : {-0.5, 0.5})
    add_box(scene, place.at(0.42, side * (width - 0.2), 0.05), 0.8, 0.2, 0.56, BoxSkin(cloth));
  const int cushions = std::max(2, static_cast<int>(width / 0.65));
  for (int i = 0; i < cushions; ++i) {
    const double w = (width - 0.45) / cushions, y = (i + 0.5 - 0.5 * cushions) * w;
    add_box(scene, place.at(0.52, y, 0.39), 0.6, w - 0.03, 0.09, BoxSkin(cloth));
    if (random.below(3) == 0) continue;
    const Skin cushion = painted(scene, carpet(random, 0.42, 0.42, 300, random.uniform(80, 190)));
    add_box(scene, place.at(0.32, y + random.uniform(-0.1, 0.1), 0.47, random.uniform(-0.3, 0.3)), 0.12, 0.42, 0.4,
            BoxSkin(cushion));
  }
}

void add_boxes(Scene& scene, const Place& place) {
  Random& random = scene.random;
  double z = 0, size = random.uniform(0.45, 0.6);
  for (int i = 0; i < 3; ++i) {
    const double h = size * random.uniform(0.55, 0.8), d = size * 0.8;
    BoxSkin skin(painted(scene, cardboard(random, size, h, 260)));
    skin.left = skin.right = painted(scene, cardboard(random, d, h, 260));
    skin.top = painted(scene, cardboard(random, size, d, 260));
    add_box(scene, place.at(0.35, random.uniform(-0.05, 0.05), z, random.uniform(-0.3, 0.3)), d, size, h, skin);
    z += h;
    size *= random.uniform(0.65, 0.85);
  }
}

void add_radiator(Scene& scene, const Place& place, double width) {
  const Skin paint = material(scene, plaster(scene.random, 0.8, 0.8, 220, 205));
  const int ribs = static_cast<int>(width / 0.08);
  for (int i = 0; i < ribs; ++i) {
    add_box(scene, place.at(0.08, (i + 0.5) * 0.08 - 0.5 * width, 0.12), 0.1, 0.055, 0.6, BoxSkin(paint),
            Bottom::closed);
  }
  add_box(scene, place.at(0.08, 0, 0.16), 0.04, width, 0.04, BoxSkin(paint), Bottom::closed);
  add_box(scene, place.at(0.08, 0, 0.64), 0.04, width, 0.04, BoxSkin(paint), Bottom::closed);
}

void add_foliage(Scene& scene, const Vector3d& centre, double radius, double leaf, int count, int texture) {
  Random& random = scene.random;
  for (int i = 0; i < count; ++i) {
    // Leaves lie near the surface of the crown and face roughly outwards; each shows its own piece of the texture.
    const double z = random.uniform(-1, 1), a = random.uniform(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
    const Vector3d out(r * std::cos(a), r * std::sin(a), z);
    const Vector3d at = centre + out * radius * std::cbrt(random.uniform(0.15, 1));
    const Vector3d face =
        (out + 0.9 * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1))).normalized();
    const Vector3d side = face.cross(Vector3d(0.31, 0.17, 0.93)).normalized() * leaf, up = face.cross(side);
    std::vector<Vector3d> corners;
    for (int k = 0; k < 6; ++k) {
      const double angle = 2 * std::numbers::pi * (k + random.uniform(-0.3, 0.3)) / 6, size = random.uniform(0.6, 1);
      corners.push_back(at + size * (std::cos(angle) * side + std::sin(angle) * up));
    }
    const Vector3d origin = at - side * random.uniform(1, 6) - up * random.uniform(1, 6);
    Polygon& p = scene.add_polygon(
        corners, origin, side * 6, up * 6,
        {.texture = texture, .gain = 0.75 + 0.35 * out.z() + random.uniform(-0.2, 0.2), .detail = 0.1});
    p.two_sided = true;
  }
}

void add_plant(Scene& scene, const Place& place, double height) {
  Random& random = scene.random;
  const Place at = place.at(0.3, 0, 0);
  const Skin pot = painted(scene, wallpaper(random, 0.9, 0.35, 220, random.uniform(90, 190)));
  const Skin soil = material(scene, plaster(random, 0.4, 0.4, 150, 45));
  add_prism(scene, at, 0.13, 0.18, 0.32, 12, pot, soil);
  const int texture = scene.add_texture(leaves(random, 0.6, 0.6, 260));
  for (int i = 0; i < 3; ++i) {
    const double z = 0.45 + (height - 0.7) * (i + 0.5) / 3;
    add_foliage(scene, at(random.uniform(-0.08, 0.08), random.uniform(-0.08, 0.08), z), 0.3, 0.11, 34, texture);
  }
  add_prism(scene, at.at(0, 0, 0.3), 0.02, 0.012, height - 0.6, 6, soil, soil);
}

void add_floor_lamp(Scene& scene, const Place& place) {
  Random& random = scene.random;
  const Skin metal = material(scene, plaster(random, 0.4, 0.4, 150, 70));
  const Place at = place.at(0.25, 0, 0);
  add_prism(scene, at, 0.15, 0.14, 0.03, 14, metal, metal);
  add_prism(scene, at.at(0, 0, 0.03), 0.015, 0.015, 1.35, 6, metal, metal);
  const Skin shade = painted(scene, wallpaper(random, 1.2, 0.32, 200, 200));
  add_prism(scene, at.at(0, 0, 1.35), 0.22, 0.14, 0.32, 16, shade, metal);
}

void add_picture(Scene& scene, const Place& place, double width, double height, const Canvas& picture,
                 double thickness) {
  Random& random = scene.random;
  const Skin frame = material(scene, planks(random, 0.4, 0.4, 240, random.uniform(30, 190), 0.1));
  const double border = thickness > 0.01 ? 0.035 : 0;
  if (thickness > 0.01) {
    add_box(scene, place.at(0.5 * thickness, 0, -0.5 * height), thickness, width, height, BoxSkin(frame),
            Bottom::closed);
  }
  const Skin image = painted(scene, picture, 0.04);
  scene.add_rect(place(thickness + 0.003, -0.5 * width + border, 0.5 * height - border),
                 place.turn(0, width - 2 * border, 0), {0, 0, -(height - 2 * border)}, image);
}

void add_clock(Scene& scene, const Place& place, double size) {
  add_picture(scene, place, size, size, clock_face(scene.random, size, 450), 0.03);
}

}  // namespace covis::synth
