// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "synth/things/materials.h"
#include "synth/things/test_things.h"

namespace covis::synth {
namespace {

TEST(Outdoors, NoTwoAreAlikeAndASeedGivesTheSame) {
  using Paint = Canvas (*)(Random&);
  const std::vector<std::pair<std::string, Paint>> all{
      {"facade", [](Random& r) { return facade(r, 1, 0.5, 50, Front::flats, 0.3); }},
      {"pavement", [](Random& r) { return pavement(r, 1, 0.5, 50); }},
      {"grass", [](Random& r) { return grass(r, 1, 0.5, 50); }},
      {"roof", [](Random& r) { return roof(r, 1, 0.5, 50); }},
      {"fence", [](Random& r) { return fence(r, 1, 0.5, 50); }},
      {"clouds", [](Random& r) { return clouds(r, 1, 0.5, 50, 180, 230); }},
      {"skyline", [](Random& r) { return skyline(r, 1, 0.5, 50); }},
      {"car_side", [](Random& r) { return car_side(r, 1, 0.5, 50, 120); }},
      {"shop_sign", [](Random& r) { return shop_sign(r, 1, 0.5, 50); }}};
  for (const auto& [what, paint] : all) {
    const auto painted = [&, paint = paint](uint64_t seed) {
      Random random(seed);
      return paint(random);
    };
    const Canvas one = painted(1);
    EXPECT_EQ(sum_of(one), sum_of(painted(1))) << what;
    EXPECT_NE(sum_of(one), sum_of(painted(2))) << what;
    EXPECT_NEAR(one.width(), 1, 0.02) << what;
    EXPECT_NEAR(one.height(), 0.5, 0.02) << what;
    const auto [low, high] = std::ranges::minmax(one.pixels());
    EXPECT_GT(high - low, 3) << what << " has no texture";
  }
}

}  // namespace
}  // namespace covis::synth
