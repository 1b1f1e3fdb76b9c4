// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/outline_answers.h"

#include <gtest/gtest.h>

#include <initializer_list>

namespace covis {
namespace {

OutlineAnswers after(std::initializer_list<OutlineFit> fits) {
  OutlineAnswers answers;
  for (const OutlineFit& fit : fits) answers.add(fit);
  return answers;
}

OutlineFit fits(double here) { return {here, 6, 900}; }
// 26 standard deviations where depth of this size lies by so many cells, 26 / ratio where it should.
OutlineFit better(double ratio, int x, int y = 0, float scale = 1) {
  return {26 / ratio, 26, 900, {scale, scale, x, y}};
}

TEST(OutlineAnswers, ThreeTimesAsGoodElsewhereTwiceIsDisplaced) {
  const OutlineFit displaced = better(4, 10), good{20, 8, 900};
  EXPECT_FALSE(after({displaced}).are_displaced());
  EXPECT_FALSE(after({displaced, good, displaced}).are_displaced());
  EXPECT_TRUE(after({displaced, displaced}).are_displaced());
  EXPECT_TRUE(after({displaced, better(4, -20)}).are_displaced());
  EXPECT_FALSE(after({displaced, displaced, good}).are_displaced());
}

TEST(OutlineAnswers, TwiceAsGoodAtOnePlaceTwiceIsDisplaced) {
  EXPECT_TRUE(after({better(2.1, -10), better(2.1, -11, 1)}).are_displaced());
  EXPECT_FALSE(after({better(2.1, -10), better(2.1, 10)}).are_displaced());
  EXPECT_FALSE(after({better(1.9, -10), better(1.9, -10)}).are_displaced());
  EXPECT_FALSE(after({better(2.5, 0), better(2.5, 0, 0, -1)}).are_displaced());
}

TEST(OutlineAnswers, AQuarterBetterAtOnePlaceThreeTimesIsDisplaced) {
  const auto three = [](const OutlineFit& fit) { return after({fit, fit, fit}); };
  EXPECT_TRUE(three(better(1.3, -10)).are_displaced());
  EXPECT_FALSE(three(better(1.2, -10)).are_displaced());
  EXPECT_TRUE(three(better(1.6, 0, 0, -1)).are_displaced()) << "turned round";
  EXPECT_FALSE(three(better(1.4, 0, 0, -1)).are_displaced()) << "few places are tried";
  EXPECT_FALSE(after({better(1.3, -10), better(1.3, -10)}).are_displaced());
  EXPECT_FALSE(after({better(1.3, -10), better(1.3, -10), better(1.3, 10), better(1.3, -10)}).are_displaced());
  OutlineFit few = better(2.3, -10);
  few.outlines = 100;
  EXPECT_FALSE(three(few).are_displaced());
  few.here = few.elsewhere / 2.5;
  EXPECT_TRUE(three(few).are_displaced());
}

TEST(OutlineAnswers, FarBetterByAnotherSizeIsDisplacedWhereTheSizesAreAlike) {
  EXPECT_TRUE(after({better(2.5, 0, 0, 0.5f), better(2.5, 2, 2, 0.63f)}).are_displaced());
  EXPECT_FALSE(after({better(2.5, 0, 0, 0.5f), better(2.5, 0, 0, 0.71f)}).are_displaced());
  EXPECT_FALSE(after({better(2.3, 0, 0, 0.79f), better(2.3, 0, 0, 0.79f)}).are_displaced())
      << "as of a camera whose depth is nearly registered";
}

TEST(OutlineAnswers, ThreeThatFitBadlyFitNowhere) {
  EXPECT_FALSE(after({fits(3), fits(3)}).fit_nowhere());
  EXPECT_TRUE(after({fits(4.9), fits(4.9), fits(4.9)}).fit_nowhere());
  EXPECT_FALSE(after({fits(9), fits(4.9), fits(4.9)}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), fits(3), fits(5.1)}).fit_nowhere()) << "the last one fits";
  EXPECT_DOUBLE_EQ(after({fits(9), fits(3), fits(4), fits(5)}).fit(), 4);
}

TEST(OutlineAnswers, TheyFitNowhereUntilOneFitsOrThreeTellLittle) {
  const OutlineFit few{1, 5, 50};
  EXPECT_FALSE(after({fits(3), fits(3), fits(3), fits(5.1)}).fit_nowhere());
  EXPECT_TRUE(after({fits(3), few, few, fits(3), fits(3)}).fit_nowhere()) << "a few that tell little are passed over";
  EXPECT_TRUE(after({fits(3), fits(3), fits(3), few, few}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), fits(3), fits(3), few, few, few}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), fits(3), few, few, few, fits(3)}).fit_nowhere());
}

TEST(OutlineAnswers, ACameraThatStandsRepeatsItselfAndCanEndADoubt) {
  const auto again = [](OutlineFit fit) {
    fit.new_view = false;
    return fit;
  };
  EXPECT_FALSE(after({better(4, -10), again(better(4, -10)), again(better(4, -10))}).are_displaced());
  EXPECT_TRUE(after({better(4, -10), again(better(4, -10)), better(4, -10)}).are_displaced());
  EXPECT_TRUE(after({better(4, -10), better(4, -10), again(better(4, -10))}).are_displaced());
  EXPECT_FALSE(after({better(4, -10), better(4, -10), again(fits(20))}).are_displaced());
  EXPECT_FALSE(after({fits(3), again(fits(3)), again(fits(3))}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), fits(3), fits(3), again(fits(6))}).fit_nowhere());
}

TEST(OutlineAnswers, FramesAreLookedAtMoreOftenAtFirstAndInDoubt) {
  OutlineAnswers answers;
  const auto looked_at = [&](int frames) {
    int count = 0;
    for (int i = 0; i < frames; ++i) count += answers.is_next_due();
    return count;
  };
  EXPECT_EQ(looked_at(50), 25);
  EXPECT_EQ(looked_at(400), 100);
  answers.add(fits(3));
  EXPECT_EQ(looked_at(20), 10);
  answers.add(fits(12));
  EXPECT_EQ(looked_at(20), 5);
  answers.add(better(1.3, 10));
  EXPECT_EQ(looked_at(20), 10);
  answers.add({0, 0, 0});
  EXPECT_EQ(looked_at(20), 5) << "a blank wall";
  for (int i = 0; i < 3; ++i) answers.add(fits(3));
  ASSERT_TRUE(answers.fit_nowhere());
  EXPECT_EQ(looked_at(20), 20) << "so that a doubt ends soon";
}

}  // namespace
}  // namespace covis
