// SPDX-License-Identifier: Apache-2.0
// Procedural materials and printed objects, painted on canvases. Every call uses new numbers of the given random
// generator, so that no two walls, posters or books look the same. Sizes in metres; ppm: pixels per metre.
#pragma once

#include <string>

#include "covis/core/random.h"
#include "synth/render/canvas.h"

namespace covis::synth {

// Surface materials.
Canvas plaster(Random& random, double w, double h, double ppm, double tone);    // painted wall, with stains and repairs
Canvas wallpaper(Random& random, double w, double h, double ppm, double tone);  // printed ornaments that vary
Canvas bricks(Random& random, double w, double h, double ppm, double tone);
Canvas planks(Random& random, double w, double h, double ppm, double tone,
              double plank);  // boards along x, `plank` wide
Canvas tiles(Random& random, double w, double h, double ppm, double tone, double tile);
Canvas carpet(Random& random, double w, double h, double ppm, double tone);
Canvas fabric(Random& random, double w, double h, double ppm, double tone);
Canvas ceiling_panels(Random& random, double w, double h, double ppm, double panel);

// Printed objects.
Canvas poster(Random& random, double w, double h, double ppm);
Canvas book_row(Random& random, double w, double h, double ppm);  // spines side by side
Canvas book_cover(Random& random, double w, double h, double ppm);
Canvas door(Random& random, double w, double h, double ppm);
Canvas view_outside(Random& random, double w, double h, double ppm);  // the view through a window
Canvas drawers(Random& random, double w, double h, double ppm, int columns, int rows);
Canvas cardboard(Random& random, double w, double h, double ppm);
Canvas notice_board(Random& random, double w, double h, double ppm);
Canvas whiteboard(Random& random, double w, double h, double ppm);
Canvas screen(Random& random, double w, double h, double ppm);
Canvas keyboard(Random& random, double w, double h, double ppm);
Canvas clock_face(Random& random, double size, double ppm);
Canvas leaves(Random& random, double w, double h, double ppm);
Canvas label(Random& random, double w, double h, double ppm);

// Outdoor materials.
enum class Front { flats, shop, office, warehouse };
Canvas facade(Random& random, double w, double h, double ppm, Front front, double storey);
// The road runs along x, with its centre line in the middle.
enum class Crossing { none, striped };
Canvas road(Random& random, double w, double h, double ppm, Crossing crossing);
Canvas pavement(Random& random, double w, double h, double ppm);
Canvas grass(Random& random, double w, double h, double ppm);
Canvas roof(Random& random, double w, double h, double ppm);
Canvas fence(Random& random, double w, double h, double ppm);
Canvas clouds(Random& random, double w, double h, double ppm, double bottom,
              double top);                                       // tones at the bottom and top edge
Canvas skyline(Random& random, double w, double h, double ppm);  // distant houses and trees against the sky's tone
Canvas car_side(Random& random, double w, double h, double ppm, double paint);
enum class CarEnd { front, back };
Canvas car_end(Random& random, double w, double h, double ppm, double paint, CarEnd end);
Canvas shop_sign(Random& random, double w, double h, double ppm);

// Returns a random word of capital letters.
std::string made_up_word(Random& random, int length);

}  // namespace covis::synth
