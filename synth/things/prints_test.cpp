// SPDX-License-Identifier: Apache-2.0
#include "synth/things/prints.h"

#include <gtest/gtest.h>

#include <utility>

#include "synth/things/test_things.h"

namespace covis::synth {
namespace {

using Print = void (*)(Canvas&, Random&, double, double, double, double);

TEST(Prints, StayInTheirBoxAndDifferByTheirRandomNumbers) {
  for (const Print print : {Print{landscape}, Print{abstract}, Print{portrait}, Print{chart}}) {
    std::pair<double, double> sums;
    for (const uint64_t seed : {1u, 2u}) {
      Canvas c(1, 1, 100, 128);
      Random random(seed);
      print(c, random, 0.3, 0.3, 0.7, 0.7);
      double outside = 0, inside = 0;
      for (int y = 0; y < 100; ++y) {
        for (int x = 0; x < 100; ++x) {
          const bool in = x >= 29 && x <= 70 && y >= 29 && y <= 70;
          (in ? inside : outside) += std::abs(static_cast<double>(c.pixels()[static_cast<size_t>(100 * y + x)]) - 128);
        }
      }
      EXPECT_GT(inside, 1000);
      // A portrait leaves the paper below it white.
      if (print != Print{portrait}) {
        EXPECT_LT(outside, 0.05 * inside);
      }
      (seed == 1 ? sums.first : sums.second) = sum_of(c);
    }
    EXPECT_NE(sums.first, sums.second);
  }
}

TEST(Prints, TextFillsItsBoxWithLines) {
  Canvas c(1, 1, 100, 200);
  Random random(1);
  print_text(c, random, 0.2, 0.2, 0.8, 0.8, 0.05, 20);
  int dark_rows = 0, light_rows = 0;
  for (int y = 20; y < 80; ++y) {
    int dark = 0;
    for (int x = 20; x < 80; ++x) dark += c.pixels()[static_cast<size_t>(100 * y + x)] < 120;
    ++(dark > 3 ? dark_rows : light_rows);
  }
  EXPECT_GT(dark_rows, 15);
  EXPECT_GT(light_rows, 5);
}

}  // namespace
}  // namespace covis::synth
