// SPDX-License-Identifier: Apache-2.0
// Facades, roads and street materials.
#include <numbers>

#include "synth/things/materials.h"

namespace covis::synth {
namespace {

struct WindowStyle {
  double width, height, bar;
  int columns, rows;
  bool lintel, shutters;
  double frame;
};

WindowStyle window_style(Random& random, double storey) {
  WindowStyle s;
  s.width = random.uniform(0.9, 1.6);
  s.height = std::min(storey - 1.0, random.uniform(1.3, 2.0));
  s.bar = random.uniform(0.04, 0.07);
  s.columns = 1 + static_cast<int>(random.below(3));
  s.rows = 1 + static_cast<int>(random.below(3));
  s.lintel = random.below(2);
  s.shutters = random.below(4) == 0;
  s.frame = random.below(3) ? random.uniform(200, 240) : random.uniform(30, 80);
  return s;
}

void draw_window(Canvas& c, Random& random, const WindowStyle& s, double x, double y) {
  const double w = s.width, h = s.height;
  c.rect(x - 0.09, y - 0.07, x + w + 0.09, y + h + 0.03, s.frame - 20);
  if (s.lintel) {
    c.rect(x - 0.2, y - 0.3, x + w + 0.2, y - 0.08, 190 + random.uniform(-12, 12));
    c.line(x - 0.2, y - 0.08, x + w + 0.2, y - 0.08, 0.05, 60);
  }
  const double glass = random.uniform(25, 75);
  c.rect(x, y, x + w, y + h, glass);
  // Windows show the sky, a curtain or blind, or a lit room.
  const uint32_t kind = random.below(6);
  const double edge = random.uniform(0.2, 0.7);
  if (kind < 2) c.triangle({x, x + w * edge, x}, {y, y, y + h * edge}, glass + 90, 0.8);
  if (kind == 2) c.rect(x, y, x + w, y + h * edge, random.uniform(140, 210), 0.9);
  if (kind == 3) {
    c.rect(x, y, x + w * 0.25, y + h, random.uniform(130, 220), 0.9);
    c.rect(x + w * 0.75, y, x + w, y + h, random.uniform(130, 220), 0.9);
  }
  if (kind == 4) c.rect(x, y, x + w, y + h, random.uniform(150, 215), 0.8);
  for (int i = 1; i < s.columns; ++i)
    c.rect(x + w * i / s.columns - 0.5 * s.bar, y, x + w * i / s.columns + 0.5 * s.bar, y + h, s.frame);
  for (int i = 1; i < s.rows; ++i)
    c.rect(x, y + h * i / s.rows - 0.5 * s.bar, x + w, y + h * i / s.rows + 0.5 * s.bar, s.frame);
  c.frame(x, y, x + w, y + h, s.bar, s.frame);
  c.rect(x - 0.12, y + h, x + w + 0.12, y + h + 0.09, 205);
  c.line(x - 0.12, y + h + 0.12, x + w + 0.12, y + h + 0.12, 0.06, 50, 0.7);
  if (s.shutters) {
    for (const double at : {x - 0.5, x + w + 0.1}) {
      c.rect(at, y, at + 0.4, y + h, 75);
      for (double slat = y + 0.05; slat < y + h - 0.05; slat += 0.09)
        c.line(at + 0.04, slat, at + 0.36, slat, 0.03, 120);
    }
  }
}

void draw_door(Canvas& c, Random& random, double x, double h, double width) {
  const double top = h - random.uniform(2.2, 2.6), tone = random.uniform(30, 140);
  c.rect(x - 0.15, top - 0.15, x + width + 0.15, h, 200);
  c.rect(x, top, x + width, h, tone);
  c.rect(x + 0.1, top + 0.1, x + width - 0.1, top + 0.45, 60);
  for (int r = 0; r < 3; ++r) {
    for (const double side : {0.1, 0.55}) {
      const double y = top + 0.6 + r * 0.6;
      if (y + 0.45 < h) c.frame(x + side * width, y, x + (side + 0.35) * width, y + 0.45, 0.04, tone + 50);
    }
  }
  c.disc(x + 0.9 * width, h - 1.05, 0.05, 225);
  c.rect(x + width + 0.25, top + 0.5, x + width + 0.55, top + 0.7, 230);
  c.text(x + width + 0.29, top + 0.54, 0.12, std::to_string(1 + random.below(98)), 25);
}

void draw_shop(Canvas& c, Random& random, double w, double h, double height) {
  const double top = h - height, paint = random.uniform(30, 190);
  c.rect(0.15, top, w - 0.15, h, paint);
  c.rect(0.3, top + 0.08, w - 0.3, top + 0.75, paint > 110 ? 35 : 215);
  const double letter = 0.42;
  const int letters = std::clamp(static_cast<int>((w - 1.2) / (letter * 0.9)), 3, 13);
  c.text(0.6, top + 0.2, letter, made_up_word(random, letters), paint > 110 ? 235 : 30);
  double x = 0.35;
  while (x < w - 1.0) {  // panes with goods behind them, and a door
    const double pane = std::min(random.uniform(1.2, 2.4), w - 0.35 - x);
    c.rect(x, top + 0.9, x + pane - 0.1, h - 0.35, random.uniform(30, 70));
    const int goods = 5 + static_cast<int>(random.below(9));
    for (int i = 0; i < goods; ++i) {
      const double gw = random.uniform(0.08, 0.3), gh = random.uniform(0.1, 0.5),
                   gx = x + random.uniform(0.05, std::max(0.06, pane - gw - 0.15));
      const double floor = h - 0.4 - (random.below(2) ? 0.9 : 0.0), t = random.uniform(70, 240);
      if (random.below(3)) {
        c.rect(gx, floor - gh, gx + gw, floor, t);
      } else {
        c.disc(gx + 0.5 * gw, floor - 0.5 * gw, 0.5 * gw, t);
      }
    }
    if (random.below(3) == 0) {
      c.rect(x + 0.2, top + 1.1, x + 0.8, top + 1.5, 235);
      c.text(x + 0.25, top + 1.2, 0.16, made_up_word(random, 3), 30);
    }
    c.line(x, h - 1.3, x + pane - 0.1, h - 1.3, 0.04, 140);
    x += pane;
  }
}

}  // namespace

Canvas facade(Random& random, double w, double h, double ppm, Front front, double storey) {
  const double tone = random.uniform(95, 190);
  Canvas c(w, h, ppm, tone);
  const uint32_t wall = random.below(4);
  if (wall == 0 || front == Front::warehouse) {  // bricks in courses
    int row = 0;
    for (double y = 0; y < h; y += 0.1, ++row) {
      for (double x = (row % 2) * -0.15; x < w; x += 0.3) {
        c.rect(x + 0.025, y + 0.025, x + 0.3, y + 0.1,
               tone - 25 + random.uniform(-34, 26) - (random.below(12) == 0 ? 35 : 0), 0.85);
      }
    }
  } else if (wall == 1) {  // large blocks of stone
    int row = 0;
    for (double y = 0; y < h; y += 0.45, ++row) {
      for (double x = (row % 2) * -0.4 - random.uniform(0, 0.2); x < w; x += random.uniform(0.6, 1.0)) {
        c.rect(x + 0.03, y + 0.03, x + 1.0, y + 0.45, tone + random.uniform(-26, 22));
        c.line(x, y, x, y + 0.45, 0.04, tone - 50);
      }
      c.line(0, y, w, y, 0.04, tone - 50);
    }
  } else if (wall == 2) {  // boards
    for (double y = 0; y < h; y += 0.2) {
      c.rect(0, y, w, y + 0.2, tone + random.uniform(-14, 14));
      c.line(0, y, w, y, 0.04, tone - 45);
    }
  } else {  // plaster, patched
    c.spots(0.3, 0.1, 0.6, tone - 25, 0.5, random.next());
    c.spots(0.2, 0.1, 0.5, tone + 22, 0.5, random.next());
  }
  c.fractal(4, 14, 7, 0.78, random.next());
  c.noise(0.5, 5, 7, random.next());  // streaks of rain

  const double ground = front == Front::shop ? 3.4 : storey;
  const WindowStyle style = window_style(random, storey);
  const double pitch = style.width + random.uniform(0.7, 1.6) + (style.shutters ? 0.8 : 0.0);
  const int columns = std::max(1, static_cast<int>((w - 0.6) / pitch));
  const double left = 0.5 * (w - columns * pitch + pitch - style.width);
  for (double base = h - ground; base > storey * 0.6; base -= storey) {
    for (int i = 0; i < columns; ++i) {
      const double x = left + i * pitch, y = base - storey + 0.5 * (storey - style.height);
      if (y < 0.35) continue;
      if (front == Front::warehouse && random.below(3) == 0) continue;
      draw_window(c, random, style, x, y);
    }
    c.rect(0, base - 0.08, w, base + 0.08, tone + 40, 0.8);
    c.line(0, base + 0.1, w, base + 0.1, 0.05, tone - 60, 0.8);
  }
  if (front == Front::shop) {
    draw_shop(c, random, w, h, 3.2);
  } else {
    const int door_column = static_cast<int>(random.below(static_cast<uint32_t>(columns)));
    for (int i = 0; i < columns; ++i) {
      const double x = left + i * pitch;
      if (i == door_column) {
        draw_door(c, random, x, h - 0.1, 1.1);
      } else if (front == Front::warehouse) {
        c.rect(x - 0.3, h - 2.8, x + style.width + 0.3, h, 70);
        for (double y = h - 2.7; y < h; y += 0.15) c.line(x - 0.25, y, x + style.width + 0.25, y, 0.04, 120);
      } else {
        draw_window(c, random, style, x, h - ground + 0.5 * (storey - style.height));
      }
    }
    c.rect(0, h - 0.45, w, h, tone - 45, 0.6);
  }
  c.rect(0, 0, w, 0.22, tone + 45);  // cornice
  c.line(0, 0.26, w, 0.26, 0.08, tone - 70);
  const int signs = static_cast<int>(random.below(3));
  for (int i = 0; i < signs; ++i) {  // plates, posters, graffiti near the ground
    const double x = random.uniform(0.3, std::max(0.4, w - 1.2)), y = h - random.uniform(1.0, 2.0);
    c.rect(x, y, x + 0.7, y + 0.5, random.uniform(190, 240));
    c.text(x + 0.06, y + 0.1, 0.16, made_up_word(random, 4), 30);
    c.rect(x + 0.06, y + 0.32, x + 0.5, y + 0.42, random.uniform(40, 120));
  }
  c.clamp_tones(12, 240);
  return c;
}

Canvas road(Random& random, double w, double h, double ppm, Crossing crossing) {
  Canvas c(w, h, ppm, 92);
  c.fractal(3, 9, 8, 0.82, random.next());
  c.noise(9, 0.7, 9, random.next());  // worn tracks
  const int patches = static_cast<int>(w * h * 0.035) + 1;
  for (int i = 0; i < patches; ++i) {
    const double x = random.uniform(0, w), y = random.uniform(0, h), pw = random.uniform(0.4, 2.4),
                 ph = random.uniform(0.3, 1.2), t = 92 + random.uniform(-38, 25);
    c.rect(x, y, x + pw, y + ph, t, 0.8);
    c.frame(x, y, x + pw, y + ph, 0.05, 50, 0.8);
  }
  for (int i = 0; i < static_cast<int>(w * 0.5) + 1; ++i) {  // cracks, some sealed
    double x = random.uniform(0, w), y = random.uniform(0, h), a = random.uniform(0, 6.28);
    const double t = random.below(3) ? 45 : 140;
    for (int k = 0; k < 8; ++k) {
      a += random.uniform(-0.6, 0.6);
      const double x2 = x + 0.4 * std::cos(a), y2 = y + 0.4 * std::sin(a);
      c.line(x, y, x2, y2, 0.035, t, 0.8);
      x = x2;
      y = y2;
    }
  }
  const int covers = static_cast<int>(w / 12) + 1;
  for (int i = 0; i < covers; ++i) {
    const double x = random.uniform(1, w - 1), y = random.uniform(1, h - 1);
    c.disc(x, y, 0.36, 50);
    c.disc(x, y, 0.3, 115);
    for (int k = -2; k <= 2; ++k) c.line(x - 0.2, y + 0.1 * k, x + 0.2, y + 0.1 * k, 0.03, 50);
  }
  const double m = 0.5 * h;
  for (double x = random.uniform(0, 2); x < w; x += 4.5) c.rect(x, m - 0.07, x + 2.2, m + 0.07, 205, 0.85);
  for (const double y : {0.35, h - 0.35}) c.rect(0, y - 0.06, w, y + 0.06, 195, 0.7);
  if (crossing == Crossing::striped) {
    const double x = random.uniform(0.3, 0.6) * w;
    for (double y = 0.5; y < h - 0.5; y += 1.0) c.rect(x, y, x + 3, y + 0.5, 215, 0.9);
  }
  if (random.below(2)) {  // an arrow
    const double x = random.uniform(0.1, 0.8) * w, y = h * 0.72;
    c.rect(x, y - 0.1, x + 2.2, y + 0.1, 205, 0.85);
    c.triangle({x + 2.2, x + 2.2, x + 3.2}, {y - 0.35, y + 0.35, y}, 205, 0.85);
  }
  c.spots(1.5, 0.02, 0.09, 40, 0.6, random.next());
  c.spots(0.7, 0.02, 0.07, 170, 0.6, random.next());
  return c;
}

Canvas pavement(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 150);
  const double slab = random.uniform(0.4, 0.8);
  for (double y = 0; y < h; y += slab) {
    for (double x = 0; x < w; x += slab) {
      const double t = 150 + random.uniform(-20, 18) - (random.below(15) == 0 ? 40 : 0);
      c.rect(x + 0.02, y + 0.02, x + slab, y + slab, t);
      c.frame(x, y, x + slab, y + slab, 0.03, 100);
    }
  }
  c.fractal(2, 11, 7, 0.8, random.next());
  c.spots(2.5, 0.02, 0.08, 75, 0.7, random.next());
  c.spots(0.8, 0.02, 0.06, 220, 0.7, random.next());
  return c;
}

Canvas grass(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 95);
  c.fractal(2.5, 20, 8, 0.85, random.next());
  c.grain(16, random.next());
  c.spots(1.2, 0.03, 0.12, 170, 0.5, random.next());
  return c;
}

Canvas roof(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 85);
  int row = 0;
  for (double y = 0; y < h; y += 0.3, ++row) {
    for (double x = (row % 2) * -0.15; x < w; x += 0.3)
      c.rect(x + 0.02, y, x + 0.3, y + 0.27, 85 + random.uniform(-24, 24));
  }
  c.fractal(2, 12, 6, 0.8, random.next());
  return c;
}

Canvas fence(Random& random, double w, double h, double ppm) {
  const double tone = random.uniform(80, 180);
  Canvas c(w, h, ppm, 35);
  const double board = random.uniform(0.12, 0.3);
  for (double x = 0; x < w; x += board)
    c.rect(x + 0.015, random.uniform(0, 0.08), x + board, h, tone + random.uniform(-28, 24));
  for (const double y : {0.2 * h, 0.8 * h}) c.rect(0, y, w, y + 0.08, tone - 30);
  for (int i = 0; i < static_cast<int>(w / 4); ++i) {
    const double x = random.uniform(0.2, std::max(0.3, w - 1.5));
    c.rect(x, 0.25 * h, x + 0.9, 0.75 * h, random.uniform(170, 240));
    c.text(x + 0.1, 0.35 * h, 0.18, made_up_word(random, 4), 30);
    c.disc(x + 0.6, 0.62 * h, 0.1, 60);
  }
  c.fractal(1.5, 12, 6, 0.8, random.next());
  return c;
}

Canvas clouds(Random& random, double w, double h, double ppm, double bottom, double top) {
  Canvas c(w, h, ppm, 0);
  c.fractal(0.22 * w, 34, 6, 0.55, random.next());
  c.each_pixel(0, 0, w, h, [&](double, double y, float& v) {
    const double t = y / h, cover = std::clamp((static_cast<double>(v) + 6) / 40, 0.0, 1.0) * (1 - t * t);
    v = static_cast<float>(top + (bottom - top) * t + (238 - top) * 0.8 * cover);
  });
  return c;
}

Canvas skyline(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 205);
  for (double layer = 0; layer < 2; ++layer) {
    double x = -random.uniform(0, 5);
    while (x < w) {
      const double width = random.uniform(5, 16), top = h * (random.uniform(0.05, 0.5) + 0.2 * layer),
                   t = 150 - 45 * layer + random.uniform(-25, 25);
      c.rect(x, top, x + width, h, t);
      if (random.below(2)) c.triangle({x, x + width, x + 0.5 * width}, {top, top, top - 2}, t - 40);
      for (double y = top + 1; y < h - 1; y += 3) {
        for (double wx = x + 1; wx < x + width - 1.5; wx += 2.4)
          c.rect(wx, y, wx + 1.2, y + 1.5, t - random.uniform(20, 70));
      }
      x += width * random.uniform(0.8, 1.3);
    }
  }
  for (double x = 0; x < w; x += random.uniform(3, 9)) {
    const double r = random.uniform(2, 4.5);
    c.ellipse(x, h - 0.6 * r, r, r, random.uniform(60, 100));
  }
  c.fractal(3, 10, 6, 0.8, random.next());
  return c;
}

Canvas car_side(Random& random, double w, double h, double ppm, double paint) {
  Canvas c(w, h, ppm, paint);
  c.fractal(0.8, 6, 6, 0.8, random.next());
  c.rect(0, h * 0.85, w, h, 35);
  c.line(0, h * 0.35, w, h * 0.35, 0.04, paint > 120 ? paint - 60 : paint + 60);
  c.line(0, h * 0.6, w, h * 0.6, 0.025, 30);
  for (const double x : {0.3, 0.52, 0.74}) c.line(x * w, 0.05, x * w, h * 0.85, 0.02, 30);
  for (const double x : {0.45, 0.67}) c.rect(x * w, h * 0.2, x * w + 0.18, h * 0.2 + 0.05, 225);
  for (const double x : {0.19, 0.81}) c.disc(x * w, h * 0.95, 0.36, 15);
  c.rect(0, h * 0.3, 0.22, h * 0.5, 235);
  c.rect(w - 0.18, h * 0.3, w, h * 0.48, 60);
  return c;
}

Canvas car_end(Random& random, double w, double h, double ppm, double paint, CarEnd end) {
  const bool front = end == CarEnd::front;
  Canvas c(w, h, ppm, paint);
  c.fractal(0.6, 6, 6, 0.8, random.next());
  for (const double x : {0.05, 0.75}) {
    c.rect(x * w, h * 0.15, (x + 0.2) * w, h * 0.42, front ? 240 : 70);
    c.frame(x * w, h * 0.15, (x + 0.2) * w, h * 0.42, 0.03, 40);
  }
  c.rect(0.3 * w, h * 0.2, 0.7 * w, h * 0.42, front ? 30 : paint - 30);
  if (front) {
    for (int i = 1; i < 5; ++i) c.line(0.31 * w, h * (0.2 + 0.044 * i), 0.69 * w, h * (0.2 + 0.044 * i), 0.015, 150);
  }
  c.rect(0.34 * w, h * 0.55, 0.66 * w, h * 0.55 + 0.13, 235);
  c.text(0.36 * w, h * 0.55 + 0.02, 0.09, made_up_word(random, 2) + std::to_string(100 + random.below(899)), 20);
  c.rect(0, h * 0.8, w, h, 35);
  return c;
}

Canvas shop_sign(Random& random, double w, double h, double ppm) {
  const double paint = random.uniform(20, 230);
  Canvas c(w, h, ppm, paint);
  const double ink = paint > 120 ? 25 : 235;
  c.frame(0, 0, w, h, 0.04, ink);
  const int letters = std::max(2, static_cast<int>((w - 0.15) / (0.3 * h)));
  c.text(0.1, 0.15 * h, 0.32 * h, made_up_word(random, letters), ink);
  c.disc(0.3 * w, 0.74 * h, 0.14 * h, ink);
  c.triangle({0.55 * w, 0.85 * w, 0.7 * w}, {0.88 * h, 0.88 * h, 0.6 * h}, ink);
  return c;
}

}  // namespace covis::synth
