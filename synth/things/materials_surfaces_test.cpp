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

TEST(Surfaces, NoTwoAreAlikeAndASeedGivesTheSame) {
  using Paint = Canvas (*)(Random&);
  const std::vector<std::pair<std::string, Paint>> all{
      {"plaster", [](Random& r) { return plaster(r, 1, 0.5, 50, 150); }},
      {"wallpaper", [](Random& r) { return wallpaper(r, 1, 0.5, 50, 150); }},
      {"bricks", [](Random& r) { return bricks(r, 1, 0.5, 50, 150); }},
      {"planks", [](Random& r) { return planks(r, 1, 0.5, 50, 150, 0.1); }},
      {"tiles", [](Random& r) { return tiles(r, 1, 0.5, 50, 150, 0.2); }},
      {"carpet", [](Random& r) { return carpet(r, 1, 0.5, 50, 150); }},
      {"fabric", [](Random& r) { return fabric(r, 1, 0.5, 50, 150); }},
      {"ceiling_panels", [](Random& r) { return ceiling_panels(r, 1, 0.5, 50, 0.25); }}};
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
