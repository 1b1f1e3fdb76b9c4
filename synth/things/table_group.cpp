// SPDX-License-Identifier: Apache-2.0
#include "synth/things/table_group.h"

#include <numbers>

#include "synth/things/furniture.h"
#include "synth/things/materials.h"

namespace covis::synth {

void add_table_group(Scene& scene, const Vector2d& at, std::vector<Floor>& floors) {
  Random& random = scene.random;
  const Skin wood = material(scene, planks(random, 1.5, 1.5, 220, random.uniform(90, 180), 0.14));
  const Place middle{{at.x(), at.y(), 0}, random.uniform(-0.3, 0.3)};
  // A rug under the table.
  const Canvas rug = carpet(random, 2.0, 1.5, 190, random.uniform(90, 160));
  const Skin rug_skin = painted(scene, rug, 0.12);
  scene.add_rect(middle(-0.75, -1.0, 0.006), middle.turn(0, 2.0, 0), middle.turn(1.5, 0, 0), rug_skin);
  add_shadow(floors, middle.at(-0.4, 0, 0), 0.8, 1.2);
  add_table(scene, middle, 0.7, 1.1, 0.72, wood);
  for (const double side : {-1.0, 1.0}) {
    const double y = side * random.uniform(0.12, 0.3);
    add_chair(scene,
              middle.at(-side * 0.62, y, 0,
                        side > 0 ? random.uniform(-0.3, 0.3) : std::numbers::pi + random.uniform(-0.3, 0.3)),
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

}  // namespace covis::synth
