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

TEST(PrintedThings, NoTwoAreAlikeAndASeedGivesTheSame) {
  using Paint = Canvas (*)(Random&);
  const std::vector<std::pair<std::string, Paint>> all{
      {"poster", [](Random& r) { return poster(r, 1, 0.5, 50); }},
      {"book_row", [](Random& r) { return book_row(r, 1, 0.5, 50); }},
      {"book_cover", [](Random& r) { return book_cover(r, 1, 0.5, 50); }},
      {"door", [](Random& r) { return door(r, 1, 0.5, 50); }},
      {"view_outside", [](Random& r) { return view_outside(r, 1, 0.5, 50); }},
      {"drawers", [](Random& r) { return drawers(r, 1, 0.5, 50, 2, 3); }},
      {"cardboard", [](Random& r) { return cardboard(r, 1, 0.5, 50); }},
      {"notice_board", [](Random& r) { return notice_board(r, 1, 0.5, 50); }},
      {"whiteboard", [](Random& r) { return whiteboard(r, 1, 0.5, 50); }},
      {"screen", [](Random& r) { return screen(r, 1, 0.5, 50); }},
      {"leaves", [](Random& r) { return leaves(r, 1, 0.5, 50); }},
      {"label", [](Random& r) { return label(r, 1, 0.5, 50); }}};
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

TEST(PrintedThings, WordsAreOfCapitalLetters) {
  Random random(1);
  for (const int length : {1, 5, 9}) {
    const std::string word = made_up_word(random, length);
    EXPECT_EQ(word.size(), static_cast<size_t>(length));
    for (const char c : word) EXPECT_TRUE(c >= 'A' && c <= 'Z') << word;
  }
}

}  // namespace
}  // namespace covis::synth
