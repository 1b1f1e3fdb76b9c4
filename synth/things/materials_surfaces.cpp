// SPDX-License-Identifier: Apache-2.0
// Materials of walls, floors and furniture.
#include <numbers>

#include "synth/things/materials.h"

namespace covis::synth {

Canvas plaster(Random& random, double w, double h, double ppm, double tone) {
  Canvas c(w, h, ppm, tone);
  c.fractal(1.3, 10, 7, 0.72, random.next());
  c.spots(1.5, 0.02, 0.12, tone + random.uniform(-25, 25), 0.35, random.next());  // repaired patches
  c.spots(30, 0.004, 0.018, tone - 60, 0.6, random.next());                       // nail holes, dents
  for (int i = 0; i < static_cast<int>(w * h * 0.5) + 1; ++i) {                   // hair cracks
    double x = random.uniform(0, w), y = random.uniform(0, h), a = random.uniform(0, 6.28);
    for (int k = 0; k < 9; ++k) {
      a += random.uniform(-0.7, 0.7);
      const double x2 = x + 0.05 * std::cos(a), y2 = y + 0.05 * std::sin(a);
      c.line(x, y, x2, y2, 0.005, tone - 45, 0.6);
      x = x2;
      y = y2;
    }
  }
  return c;
}

Canvas wallpaper(Random& random, double w, double h, double ppm, double tone) {
  Canvas c(w, h, ppm, tone);
  const double stripe = random.uniform(0.09, 0.2), dark = tone - random.uniform(15, 35);
  for (double x = 0; x < w; x += stripe * 2) c.rect(x, 0, x + stripe * random.uniform(0.8, 1.1), h, dark, 0.7);
  // Ornaments in rows, each a little different.
  const double step = random.uniform(0.24, 0.36);
  const uint32_t kind = random.below(3);
  int row = 0;
  for (double y = step * 0.5; y < h; y += step, ++row) {
    for (double x = row % 2 ? step : step * 0.5; x < w; x += step) {
      const double s = step * random.uniform(0.10, 0.26),
                   t = tone + (random.below(2) ? 45 : -70) + random.uniform(-12, 12);
      const double ox = x + random.uniform(-0.02, 0.02), oy = y + random.uniform(-0.02, 0.02);
      if (kind == 0) {
        for (int p = 0; p < 5; ++p) {
          const double a = 2 * std::numbers::pi * p / 5 + random.uniform(-0.3, 0.3);
          c.disc(ox + s * 0.7 * std::cos(a), oy + s * 0.7 * std::sin(a), s * 0.4, t);
        }
        c.disc(ox, oy, s * 0.35, tone - 80);
      } else if (kind == 1) {
        c.triangle({ox - s, ox + s, ox}, {oy + s, oy + s, oy - s}, t);
        c.disc(ox, oy + s * 0.3, s * 0.3, tone + 40);
      } else {
        c.rect(ox - s, oy - s * 0.5, ox + s, oy + s * 0.5, t);
        c.line(ox, oy - s * 1.6, ox, oy + s * 1.6, 0.012, tone - 60);
      }
    }
  }
  c.fractal(0.9, 12, 7, 0.7, random.next());
  return c;
}

Canvas bricks(Random& random, double w, double h, double ppm, double tone) {
  Canvas c(w, h, ppm, tone + 45);  // mortar
  c.fractal(0.2, 12, 5, 0.8, random.next());
  const double height = 0.071, length = 0.24, gap = 0.011;
  int row = 0;
  for (double y = 0; y < h; y += height, ++row) {
    for (double x = (row % 2) * -0.5 * length; x < w; x += length) {
      double t = tone + random.uniform(-28, 24);
      if (random.below(9) == 0) t -= 42;  // burnt bricks
      if (random.below(17) == 0) t += 45;
      const double e = random.uniform(-0.003, 0.003);
      c.rect(x + gap, y + gap + e, x + length, y + height + e, t);
      if (random.below(4) == 0) {  // a chipped corner
        c.disc(x + (random.below(2) ? gap : length), y + random.uniform(gap, height), random.uniform(0.006, 0.02),
               tone + 45);
      }
    }
  }
  c.fractal(1.5, 14, 8, 0.75, random.next());
  c.grain(4, random.next());
  return c;
}

Canvas planks(Random& random, double w, double h, double ppm, double tone, double plank) {
  Canvas c(w, h, ppm, tone);
  for (double y = 0; y < h; y += plank) {
    double x = -random.uniform(0, 1.2);
    while (x < w) {
      const double length = random.uniform(0.7, 1.9), t = tone + random.uniform(-22, 22);
      c.rect(x, y, x + length, y + plank, t);
      for (int k = 0; k < 4; ++k) {  // long streaks of the grain
        const double gy = y + plank * random.uniform(0.1, 0.9);
        c.line(x + 0.02, gy, x + length - 0.02, gy + plank * random.uniform(-0.15, 0.15),
               plank * random.uniform(0.02, 0.07), t - random.uniform(8, 25), 0.7);
      }
      if (random.below(2) == 0) {  // a knot
        const double kx = x + length * random.uniform(0.1, 0.9), ky = y + plank * random.uniform(0.3, 0.7),
                     r = plank * random.uniform(0.08, 0.2);
        c.ellipse(kx, ky, r * 1.8, r, t - 30, 0.8);
        c.ellipse(kx, ky, r, r * 0.55, t - 60);
      }
      c.line(x, y, x, y + plank, 0.004, tone - 60);
      for (const double nx : {x + 0.025, x + length - 0.025}) c.disc(nx, y + plank * 0.5, 0.004, tone - 70);
      x += length;
    }
    c.line(0, y, w, y, 0.005, tone - 55);
  }
  c.noise(0.35, 0.012, 9, random.next());
  c.noise(0.12, 0.006, 7, random.next());
  c.fractal(0.8, 7, 4, 0.7, random.next());
  return c;
}

Canvas tiles(Random& random, double w, double h, double ppm, double tone, double tile) {
  Canvas c(w, h, ppm, tone - 50);
  const double gap = std::max(0.004, tile * 0.02);
  const uint32_t pattern = random.below(5) % 3;
  int row = 0;
  for (double y = 0; y < h; y += tile, ++row) {
    int column = 0;
    for (double x = 0; x < w; x += tile, ++column) {
      double t = tone + random.uniform(-10, 10);
      if (pattern == 2 && (row + column) % 2) t -= random.uniform(35, 70);
      if (pattern == 1 && random.below(6) == 0) t -= random.uniform(20, 70);
      c.rect(x + gap, y + gap, x + tile, y + tile, t);
      if (pattern == 0) {
        const double m = tile * 0.5, r = tile * random.uniform(0.12, 0.3);
        c.disc(x + m, y + m, r, t - 45);
        if (random.below(3)) c.disc(x + m, y + m, r * 0.5, t + 20);
      }
      if (random.below(14) == 0)
        c.line(x + gap, y + tile * random.uniform(), x + tile, y + tile * random.uniform(), 0.004, tone - 70);
    }
  }
  c.fractal(0.7, 12, 7, 0.75, random.next());
  return c;
}

Canvas carpet(Random& random, double w, double h, double ppm, double tone) {
  Canvas c(w, h, ppm, tone);
  double inset = 0;
  for (int band = 0; band < 4; ++band) {  // a border of bands
    const double width = random.uniform(0.03, 0.09), t = std::clamp(tone + random.uniform(-75, 75), 25.0, 220.0);
    c.frame(inset, inset, w - inset, h - inset, width, t);
    const double step = width * random.uniform(1.2, 2.2);
    if (width > 0.05) {
      for (double x = inset + step; x < w - inset; x += step) {
        c.disc(x, inset + width * 0.5, width * 0.28, tone + random.uniform(-60, 80));
        c.disc(x, h - inset - width * 0.5, width * 0.28, tone + random.uniform(-60, 80));
      }
    }
    inset += width;
  }
  const int figures = static_cast<int>(14 * w * h) + 6;
  for (int i = 0; i < figures; ++i) {
    const double r = random.uniform(0.03, 0.16),
                 x = random.uniform(inset + r, std::max(inset + r + 0.01, w - inset - r));
    const double y = random.uniform(inset + r, std::max(inset + r + 0.01, h - inset - r)),
                 t = std::clamp(tone + random.uniform(-85, 85), 20.0, 230.0);
    switch (random.below(3)) {
      case 0:
        c.disc(x, y, r, t);
        c.disc(x, y, r * 0.6, tone);
        break;
      case 1:
        c.triangle({x - r, x + r, x}, {y, y, y - r}, t);
        c.triangle({x - r, x + r, x}, {y, y, y + r}, t - 20);
        break;
      default:
        c.rect(x - r, y - r * 0.3, x + r, y + r * 0.3, t);
        c.rect(x - r * 0.3, y - r, x + r * 0.3, y + r, t);
    }
  }
  c.fractal(0.3, 12, 6, 0.85, random.next());
  c.grain(7, random.next());
  return c;
}

Canvas fabric(Random& random, double w, double h, double ppm, double tone) {
  Canvas c(w, h, ppm, tone);
  for (int axis = 0; axis < 2; ++axis) {
    double at = 0;
    const double end = axis ? h : w;
    while (at < end) {  // plaid
      const double width = random.uniform(0.008, 0.06), t = tone + random.uniform(-60, 60);
      if (axis) {
        c.rect(0, at, w, at + width, t, 0.45);
      } else {
        c.rect(at, 0, at + width, h, t, 0.45);
      }
      at += width + random.uniform(0.02, 0.1);
    }
  }
  c.fractal(0.25, 12, 6, 0.8, random.next());
  c.grain(8, random.next());
  return c;
}

Canvas ceiling_panels(Random& random, double w, double h, double ppm, double panel) {
  Canvas c(w, h, ppm, 205);
  c.spots(260, 0.004, 0.012, 130, 0.8, random.next());
  for (double x = 0; x < w; x += panel) {
    for (double y = 0; y < h; y += panel) {
      c.rect(x, y, x + panel, y + panel, 205 + random.uniform(-40, 20), 0.45);
      c.frame(x, y, x + panel, y + panel, 0.012, 150);
      if (random.below(11) == 0)
        c.ellipse(x + panel * random.uniform(), y + panel * random.uniform(), 0.12, 0.08, 150, 0.5);
      if (random.below(13) == 0) c.disc(x + panel * 0.5, y + panel * 0.5, 0.06, 70);
    }
  }
  c.fractal(1.6, 10, 5, 0.7, random.next());
  return c;
}

}  // namespace covis::synth
