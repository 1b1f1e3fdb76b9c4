// SPDX-License-Identifier: Apache-2.0
// Printed and manufactured objects: posters, books, doors, screens, labels.
#include <numbers>

#include "synth/things/materials.h"
#include "synth/things/prints.h"

namespace covis::synth {

Canvas poster(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, random.uniform(190, 240));
  const double m = 0.05 * std::min(w, h), title = h * random.uniform(0.06, 0.11);
  const double top = m + title * 1.5, bottom = h - m - h * random.uniform(0.08, 0.25);
  if (random.below(3) == 0) c.rect(0, 0, w, h, random.uniform(20, 110));
  c.rect(m, top, w - m, bottom, random.uniform(90, 220));
  switch (random.below(5)) {
    case 0:
      landscape(c, random, m, top, w - m, bottom);
      break;
    case 1:
      portrait(c, random, m, top, w - m, bottom);
      break;
    case 2:
      chart(c, random, m * 2, top + m, w - 2 * m, bottom - m);
      break;
    default:
      abstract(c, random, m, top, w - m, bottom);
  }
  c.rect(0, bottom, w, h, c.pixels().front());
  const double ink = c.pixels().front() > 128 ? 30 : 225;
  const int letters = std::clamp(static_cast<int>((w - 2 * m) / (title * 0.86)), 3, 14);
  c.text(m, m, std::min(title, (w - 2 * m) / letters * 1.16), made_up_word(random, letters), ink);
  print_text(c, random, m, bottom + m * 0.5, w - m, h - m * 0.5, std::max(0.012, h * 0.02), ink);
  c.fractal(0.25, 5, 6, 0.8, random.next());
  return c;
}

Canvas label(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, random.uniform(200, 240));
  c.frame(0, 0, w, h, 0.03 * h, random.uniform(30, 120));
  c.rect(0, 0, w, h * random.uniform(0.2, 0.3), random.uniform(40, 140));
  c.text(w * 0.08, h * 0.36, h * 0.2, made_up_word(random, 5), 30);
  print_text(c, random, w * 0.08, h * 0.62, w * 0.7, h * 0.95, h * 0.07, 60);
  double x = w * 0.74;
  while (x < w * 0.94) {  // a bar code
    const double bar = w * random.uniform(0.006, 0.02);
    c.rect(x, h * 0.6, x + bar, h * 0.92, 20);
    x += bar + w * random.uniform(0.008, 0.02);
  }
  return c;
}

Canvas book_row(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 28);
  double x = 0.002;
  while (x < w) {
    if (random.below(13) == 0) {  // a gap, or a leaning book behind it
      x += random.uniform(0.02, 0.1);
      continue;
    }
    const double width = random.uniform(0.012, 0.055), top = h * random.uniform(0.04, 0.38),
                 t = random.uniform(25, 225);
    const double ink = t > 125 ? t - random.uniform(70, 110) : t + random.uniform(70, 120);
    c.rect(x, top, x + width, h, t);
    c.line(x, top, x, h, 0.003, 15);
    const int bands = static_cast<int>(random.below(4));
    for (int i = 0; i < bands; ++i) {
      const double y = top + (h - top) * random.uniform(0.05, 0.92);
      c.rect(x + 0.001, y, x + width - 0.001, y + random.uniform(0.003, 0.015), ink, 0.9);
    }
    double y = top + (h - top) * random.uniform(0.15, 0.3);
    const double glyph = std::min(width * 0.7, 0.022);
    const int letters = 3 + static_cast<int>(random.below(8));
    for (int i = 0; i < letters && y < h - glyph * 1.5; ++i, y += glyph * 1.1) {  // the title runs down the spine
      c.text(x + 0.5 * (width - glyph * 0.7), y, glyph, made_up_word(random, 1), ink);
    }
    x += width;
  }
  c.each_pixel(0, 0, w, h, [&](double, double y, float& v) {
    v *= static_cast<float>(0.55 + 0.45 * std::min(1.0, y / (0.6 * h)));
  });
  c.fractal(0.1, 6, 5, 0.8, random.next());
  return c;
}

Canvas book_cover(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, random.uniform(35, 225));
  const double ink = c.pixels().front() > 128 ? 30 : 230;
  if (random.below(2)) {
    landscape(c, random, w * 0.08, h * 0.34, w * 0.92, h * 0.82);
  } else {
    abstract(c, random, w * 0.08, h * 0.34, w * 0.92, h * 0.82);
  }
  c.frame(0, 0, w, h, 0.02 * w, ink, 0.6);
  c.text(w * 0.08, h * 0.08, w * 0.13, made_up_word(random, 7), ink);
  c.text(w * 0.08, h * 0.22, w * 0.06, made_up_word(random, 12), ink);
  c.text(w * 0.3, h * 0.88, w * 0.06, made_up_word(random, 9), ink);
  c.fractal(0.06, 6, 5, 0.8, random.next());
  return c;
}

Canvas door(Random& random, double w, double h, double ppm) {
  const double tone = random.uniform(80, 190);
  Canvas c = planks(random, w, h, ppm, tone, w * 1.01);
  const int rows = 2 + static_cast<int>(random.below(3)), columns = 1 + static_cast<int>(random.below(2));
  const bool glazed = random.below(4) == 0;
  for (int r = 0; r < rows; ++r) {
    for (int k = 0; k < columns; ++k) {
      const double pw = (w - 0.12) / columns, ph = (h - 0.16) / rows;
      const double x0 = 0.06 + k * pw + 0.05, y0 = 0.08 + r * ph + 0.05, x1 = x0 + pw - 0.1, y1 = y0 + ph - 0.1;
      c.rect(x0, y0, x1, y1, glazed && r == 0 ? 60 : tone - 14, 0.75);
      c.line(x0, y0, x1, y0, 0.016, tone - 65);
      c.line(x0, y0, x0, y1, 0.016, tone - 50);
      c.line(x0, y1, x1, y1, 0.016, tone + 45);
      c.line(x1, y0, x1, y1, 0.016, tone + 35);
    }
  }
  c.rect(w - 0.12, h * 0.5 - 0.1, w - 0.07, h * 0.5 + 0.1, 190);  // the lock and handle
  c.rect(w - 0.2, h * 0.5 - 0.015, w - 0.08, h * 0.5 + 0.015, 225);
  c.disc(w - 0.095, h * 0.5 + 0.06, 0.01, 20);
  if (random.below(2)) {
    c.rect(w * 0.3, h * 0.17, w * 0.7, h * 0.17 + 0.13, 225);
    c.text(w * 0.34, h * 0.17 + 0.035, 0.06, std::to_string(100 + random.below(899)), 25);
  }
  if (random.below(2)) c.rect(0, h - 0.25, w, h, 140, 0.85);  // a kick plate
  c.frame(0, 0, w, h, 0.02, tone - 60);
  c.clamp_tones(8, 245);
  return c;
}

Canvas view_outside(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 225);
  landscape(c, random, 0, 0, w, h);
  double x = 0;
  while (x < w) {  // houses on the other side of the street
    const double width = w * random.uniform(0.12, 0.3), top = h * random.uniform(0.3, 0.6),
                 t = random.uniform(120, 215);
    c.rect(x, top, x + width, h * 0.85, t);
    if (random.below(2)) c.triangle({x, x + width, x + width * 0.5}, {top, top, top - h * 0.1}, t - 60);
    for (double wy = top + h * 0.05; wy < h * 0.75; wy += h * 0.12) {
      for (double wx = x + width * 0.12; wx < x + width * 0.85; wx += width * 0.28)
        c.rect(wx, wy, wx + width * 0.15, wy + h * 0.07, random.uniform(30, 110));
    }
    x += width + w * random.uniform(0, 0.08);
  }
  c.fractal(0.3, 10, 5, 0.8, random.next());
  return c;
}

Canvas drawers(Random& random, double w, double h, double ppm, int columns, int rows) {
  const double tone = random.uniform(90, 195);
  Canvas c = planks(random, w, h, ppm, tone, h * 1.01);
  for (int r = 0; r < rows; ++r) {
    for (int k = 0; k < columns; ++k) {
      const double x0 = w * k / columns + 0.015, x1 = w * (k + 1) / columns - 0.015;
      const double y0 = h * r / rows + 0.015, y1 = h * (r + 1) / rows - 0.015;
      c.frame(x0, y0, x1, y1, 0.008, tone - 70);
      const double cx = 0.5 * (x0 + x1), cy = 0.5 * (y0 + y1);
      c.rect(cx - 0.06, cy - 0.012, cx + 0.06, cy + 0.012, random.below(2) ? 225 : 30);
      if (random.below(3) == 0) {
        c.rect(cx - 0.07, cy + 0.03, cx + 0.05, cy + 0.07, 230);
        c.text(cx - 0.06, cy + 0.037, 0.024, made_up_word(random, 4), 40);
      }
    }
  }
  return c;
}

Canvas cardboard(Random& random, double w, double h, double ppm) {
  const double tone = random.uniform(125, 165);
  Canvas c(w, h, ppm, tone);
  c.noise(0.4, 0.008, 5, random.next());
  c.fractal(0.3, 12, 6, 0.75, random.next());
  const double tape = h * random.uniform(0.4, 0.6);
  c.rect(0, tape, w, tape + 0.05, tone + 50, 0.75);
  c.text(w * 0.08, h * 0.1, std::min(0.09, w * 0.11), made_up_word(random, 6), 45);
  c.rect(w * 0.55, h * 0.68, w * 0.92, h * 0.92, 225);
  print_text(c, random, w * 0.58, h * 0.7, w * 0.9, h * 0.9, h * 0.035, 40);
  c.triangle({w * 0.1, w * 0.1 + 0.06, w * 0.1 + 0.03}, {h * 0.9, h * 0.9, h * 0.9 - 0.07}, 40);
  return c;
}

Canvas notice_board(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 135);
  c.fractal(0.1, 20, 5, 0.9, random.next());
  const int sheets = static_cast<int>(w * h * 14) + 3;
  for (int i = 0; i < sheets; ++i) {
    const double sw = random.uniform(0.09, 0.24), sh = sw * random.uniform(0.7, 1.45),
                 x = random.uniform(0.03, std::max(0.04, w - sw - 0.03));
    const double y = random.uniform(0.03, std::max(0.04, h - sh - 0.03)), t = random.uniform(150, 245);
    c.shadow(x + 0.006, y + 0.006, x + sw + 0.006, y + sh + 0.006, 0.012, 0.5);
    c.rect(x, y, x + sw, y + sh, t);
    if (random.below(3) == 0) {
      abstract(c, random, x + 0.01, y + 0.01, x + sw - 0.01, y + sh - 0.01);
    } else {
      print_text(c, random, x + 0.012, y + 0.02, x + sw - 0.012, y + sh - 0.01, 0.014, 50);
    }
    c.disc(x + sw * 0.5, y + 0.012, 0.008, random.below(2) ? 20 : 250);
  }
  c.frame(0, 0, w, h, 0.03, 60);
  return c;
}

Canvas whiteboard(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 226);
  c.fractal(0.8, 7, 5, 0.7, random.next());
  for (int i = 0; i < 6; ++i) {
    double x = random.uniform(0.1, w * 0.85), y = random.uniform(0.1, h * 0.85);
    const double tone = random.uniform(25, 110);
    if (random.below(2)) {
      c.text(x, y, random.uniform(0.03, 0.07), made_up_word(random, 4 + static_cast<int>(random.below(5))), tone);
      c.line(x, y + 0.09, x + 0.3, y + 0.09, 0.006, tone);
    } else {
      c.frame(x, y, std::min(w - 0.05, x + 0.25), std::min(h - 0.05, y + 0.16), 0.007, tone);
      for (int k = 0; k < 12; ++k) {
        const double x2 = std::clamp(x + random.uniform(-0.1, 0.1), 0.05, w - 0.05),
                     y2 = std::clamp(y + random.uniform(-0.08, 0.08), 0.05, h - 0.05);
        c.line(x, y, x2, y2, 0.007, tone);
        x = x2;
        y = y2;
      }
    }
  }
  c.frame(0, 0, w, h, 0.025, 120);
  return c;
}

Canvas screen(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 35);
  const double bezel = 0.012;
  c.rect(bezel, bezel, w - bezel, h - bezel, random.uniform(50, 120));
  for (int i = 0; i < 3; ++i) {
    const double x0 = random.uniform(bezel, w * 0.5), y0 = random.uniform(bezel, h * 0.5);
    const double x1 = std::min(w - bezel, x0 + w * random.uniform(0.3, 0.55)),
                 y1 = std::min(h - bezel, y0 + h * random.uniform(0.3, 0.6));
    c.rect(x0, y0, x1, y1, random.below(2) ? 225 : 30);
    c.rect(x0, y0, x1, y0 + 0.012, random.uniform(90, 170));
    const double paper =
        static_cast<double>(c.pixels()[static_cast<size_t>(y1 / h * c.rows() - 1) * static_cast<size_t>(c.columns()) +
                                       static_cast<size_t>(x1 / w * c.columns() - 1)]);
    if (random.below(3) == 0) {
      abstract(c, random, x0, y0 + 0.014, x1, y1);
    } else {
      print_text(c, random, x0 + 0.008, y0 + 0.018, x1 - 0.006, y1 - 0.004, 0.008, paper > 128 ? 40 : 210);
    }
  }
  return c;
}

Canvas keyboard(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 40);
  const int rows = 5, columns = 15;
  const bool light_keys = random.below(2) == 0;
  for (int r = 0; r < rows; ++r) {
    for (int k = 0; k < columns; ++k) {
      const double x = w * (0.02 + 0.96 * k / columns), y = h * (0.06 + 0.9 * r / rows), kw = w * 0.96 / columns,
                   kh = h * 0.9 / rows;
      if (r == rows - 1 && k > 4 && k < 10) {
        c.rect(x, y, x + kw, y + kh * 0.85, light_keys ? 190 : 75);
        continue;
      }
      c.rect(x + kw * 0.07, y + kh * 0.07, x + kw * 0.9, y + kh * 0.85,
             (light_keys ? 190 : 75) + random.uniform(-8, 8));
      c.text(x + kw * 0.3, y + kh * 0.2, kh * 0.35, made_up_word(random, 1), light_keys ? 40 : 215);
    }
  }
  return c;
}

Canvas clock_face(Random& random, double size, double ppm) {
  Canvas c(size, size, ppm, 120);
  const double r = size * 0.5;
  c.disc(r, r, r * 0.99, 30);
  c.disc(r, r, r * 0.88, 235);
  for (int i = 0; i < 12; ++i) {
    const double a = std::numbers::pi * i / 6;
    c.line(r + r * 0.7 * std::sin(a), r - r * 0.7 * std::cos(a), r + r * 0.82 * std::sin(a), r - r * 0.82 * std::cos(a),
           r * 0.05, 25);
  }
  for (const double length : {0.42, 0.66}) {
    const double a = random.uniform(0, 6.28);
    c.line(r, r, r + r * length * std::sin(a), r - r * length * std::cos(a), r * 0.07, 15);
  }
  return c;
}

Canvas leaves(Random& random, double w, double h, double ppm) {
  Canvas c(w, h, ppm, 45);
  const double size = std::min(w, h) * 0.12;
  const int count = static_cast<int>(14 * w * h / (size * size));
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0, w), y = random.uniform(0, h), a = random.uniform(0, 6.28),
                 s = size * random.uniform(0.4, 1);
    const double t = random.uniform(35, 165);
    c.triangle({x, x + s * std::cos(a), x + 0.6 * s * std::cos(a + 0.7)},
               {y, y + s * std::sin(a), y + 0.6 * s * std::sin(a + 0.7)}, t);
    c.line(x, y, x + s * std::cos(a), y + s * std::sin(a), s * 0.06, t + 35);
  }
  return c;
}

}  // namespace covis::synth
