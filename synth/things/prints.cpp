// SPDX-License-Identifier: Apache-2.0
#include "synth/things/prints.h"

#include <array>

#include "synth/things/materials.h"

namespace covis::synth {
namespace {

constexpr size_t kRidge = 256;  // number of steps of a hill's outline

}  // namespace

std::string made_up_word(Random& random, int length) {
  static constexpr std::string_view kConsonants = "BCDFGHKLMNPRSTVZ", kVowels = "AEIOUY";
  std::string word;
  bool vowel = random.below(2) == 0;
  for (int i = 0; i < length; ++i, vowel = !vowel) {
    word += vowel ? kVowels[random.below(6)] : kConsonants[random.below(16)];
  }
  return word;
}

void print_text(Canvas& c, Random& random, double x0, double y0, double x1, double y1, double height, double tone) {
  for (double y = y0; y + height <= y1; y += height * random.uniform(1.5, 1.8)) {
    double x = x0;
    const double end = random.below(4) ? x1 : x0 + (x1 - x0) * random.uniform(0.3, 0.9);
    while (x < end - height * 2) {
      const int letters = 2 + static_cast<int>(random.below(7));
      if (x + letters * height * 0.86 > end) break;
      x += c.text(x, y, height, made_up_word(random, letters), tone) + height * 0.7;
    }
  }
}

void landscape(Canvas& c, Random& random, double x0, double y0, double x1, double y1) {
  const double w = x1 - x0, h = y1 - y0;
  c.each_pixel(x0, y0, x1, y1, [&](double x, double y, float& v) {
    if (x >= x0 && x <= x1 && y >= y0 && y <= y1) v = static_cast<float>(210 - 60 * (y - y0) / h);
  });
  c.disc(x0 + w * random.uniform(0.2, 0.8), y0 + h * random.uniform(0.15, 0.35), h * random.uniform(0.05, 0.1), 245);
  double base = random.uniform(0.4, 0.6), tone = random.uniform(130, 165);
  for (int ridge = 0; ridge < 4; ++ridge) {
    const double p1 = random.uniform(0, 6), p2 = random.uniform(0, 6), p3 = random.uniform(0, 6),
                 f = random.uniform(3, 6);
    std::array<double, kRidge + 1> tops;
    for (size_t i = 0; i <= kRidge; ++i) {
      const double t = static_cast<double>(i) / kRidge;
      tops[i] =
          base + 0.09 * std::sin(f * t + p1) + 0.04 * std::sin(2.7 * f * t + p2) + 0.02 * std::sin(7.1 * f * t + p3);
    }
    const uint64_t seed = random.next();
    c.each_pixel(x0, y0, x1, y1, [&](double x, double y, float& v) {
      if (x < x0 || x > x1 || y < y0 || y > y1) return;
      const double down = (y - y0) / h, across = (x - x0) / w * kRidge;
      if (down < tops[static_cast<size_t>(across)]) return;
      // Fields, each with another tone.
      const uint64_t field =
          mix64(seed ^ (static_cast<uint64_t>(across / 11 + 40 * down) << 8) ^ static_cast<uint64_t>(24 * down));
      v = static_cast<float>(tone + static_cast<double>(field % 31) - 15);
    });
    base += random.uniform(0.1, 0.16);
    tone -= random.uniform(25, 38);
  }
  for (int i = 0; i < 9; ++i) {  // trees
    const double x = x0 + w * random.uniform(0.05, 0.95), y = y0 + h * random.uniform(0.65, 0.97),
                 s = h * random.uniform(0.05, 0.13);
    c.triangle({x - s * 0.4, x + s * 0.4, x}, {y, y, y - s * 1.3}, random.uniform(15, 60));
  }
}

void abstract(Canvas& c, Random& random, double x0, double y0, double x1, double y1) {
  const double w = x1 - x0, h = y1 - y0;
  const int shapes = 8 + static_cast<int>(random.below(14));
  for (int i = 0; i < shapes; ++i) {
    const double x = x0 + w * random.uniform(0.1, 0.9), y = y0 + h * random.uniform(0.1, 0.9);
    const double s = std::min({0.3 * std::min(w, h) * random.uniform(0.2, 1), x - x0, x1 - x, y - y0, y1 - y}),
                 t = random.uniform(10, 245);
    switch (random.below(4)) {
      case 0:
        c.disc(x, y, s, t);
        break;
      case 1:
        c.rect(x - s, y - s * random.uniform(0.2, 1), x + s, y + s * random.uniform(0.2, 1), t);
        break;
      case 2:
        c.triangle({x - s * random.uniform(0.4, 1), x + s, x + s * random.uniform(-0.5, 0.5)},
                   {y + s, y + s * random.uniform(0, 0.8), y - s}, t);
        break;
      default:
        c.line(x - s, y - s * random.uniform(-1, 1), x + s, y + s * random.uniform(-1, 1), s * random.uniform(0.1, 0.3),
               t);
    }
  }
}

void portrait(Canvas& c, Random& random, double x0, double y0, double x1, double y1) {
  const double w = x1 - x0, h = y1 - y0, cx = 0.5 * (x0 + x1), face = y0 + h * 0.42, skin = random.uniform(140, 205);
  c.rect(x0, y0, x1, y1, random.uniform(60, 130));
  c.ellipse(cx, y1 - h * 0.02, w * 0.42, h * 0.32, random.uniform(25, 90));
  c.rect(x0, y1, x1, y1 + h * 0.3, 235);
  c.ellipse(cx, face - h * 0.06, w * 0.27, h * 0.27, random.uniform(20, 70));  // hair
  c.ellipse(cx, face, w * 0.21, h * 0.235, skin);
  for (const double side : {-1.0, 1.0}) {
    c.ellipse(cx + side * w * 0.085, face - h * 0.03, w * 0.04, h * 0.018, 240);
    c.disc(cx + side * w * 0.085, face - h * 0.03, w * 0.017, 20);
    c.line(cx + side * w * 0.04, face - h * 0.075, cx + side * w * 0.13, face - h * 0.07, h * 0.012, 45);
  }
  c.line(cx, face - h * 0.02, cx + w * 0.02, face + h * 0.06, h * 0.01, skin - 45);
  c.ellipse(cx, face + h * 0.12, w * 0.07, h * 0.014, skin - 80);
}

void chart(Canvas& c, Random& random, double x0, double y0, double x1, double y1) {
  const double w = x1 - x0, h = y1 - y0;
  c.frame(x0, y0, x1, y1, 0.004, 40);
  const int bars = 5 + static_cast<int>(random.below(7));
  for (int i = 0; i < bars; ++i) {
    const double bw = w / bars;
    c.rect(x0 + (i + 0.2) * bw, y1 - h * random.uniform(0.1, 0.9), x0 + (i + 0.8) * bw, y1, random.uniform(40, 190));
  }
  for (int i = 1; i < 5; ++i) c.line(x0, y0 + h * i / 5, x1, y0 + h * i / 5, 0.003, 120, 0.6);
}

}  // namespace covis::synth
