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

TEST(OutlineAnswers, TwiceAsGoodElsewhereTwiceIsDisplaced) {
  const OutlineFit displaced{4, 20}, good{20, 8};
  EXPECT_FALSE(after({displaced}).are_displaced());
  EXPECT_FALSE(after({displaced, good, displaced}).are_displaced());
  EXPECT_TRUE(after({displaced, displaced}).are_displaced());
  EXPECT_FALSE(after({displaced, displaced, good}).are_displaced());
}

TEST(OutlineAnswers, AQuarterBetterIsDisplacedWhereThePlaceIsTheSame) {
  const auto at = [](float scale, int x, int y) { return OutlineFit{20, 26, 900, {scale, scale, x, y}}; };
  EXPECT_TRUE(after({at(1, -10, 0), at(1, -11, 1)}).are_displaced());
  EXPECT_TRUE(after({at(-1, 0, 0), at(-1, 0, 0)}).are_displaced());
  EXPECT_FALSE(after({at(1, -10, 0), at(1, 10, 0)}).are_displaced());
  EXPECT_FALSE(after({at(1, 0, 0), at(-1, 0, 0)}).are_displaced());
  EXPECT_FALSE(after({at(0.79f, 0, 0), at(0.79f, 0, 0)}).are_displaced())
      << "as of a camera whose depth is nearly registered";
  const OutlineFit slightly{20, 24, 900, {1, 1, -10, 0}};
  EXPECT_FALSE(after({slightly, slightly}).are_displaced());
}

TEST(OutlineAnswers, TwoThatFitVeryBadlyOrThreeThatFitBadlyFitNowhere) {
  EXPECT_FALSE(after({fits(3)}).fit_nowhere());
  EXPECT_TRUE(after({fits(3), fits(3)}).fit_nowhere());
  EXPECT_FALSE(after({fits(4.9), fits(4.9)}).fit_nowhere());
  EXPECT_TRUE(after({fits(4.9), fits(4.9), fits(4.9)}).fit_nowhere());
  EXPECT_FALSE(after({fits(9), fits(4.9), fits(4.9)}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), fits(5.1)}).fit_nowhere()) << "the last one fits";
  EXPECT_DOUBLE_EQ(after({fits(3), fits(4)}).fit(), 3.5);
}

TEST(OutlineAnswers, TheyFitNowhereUntilOneFitsOrThreeTellLittle) {
  const OutlineFit few{1, 5, 50};
  EXPECT_TRUE(after({fits(3), fits(3), fits(4.9)}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), fits(3), fits(5.1)}).fit_nowhere());
  EXPECT_TRUE(after({fits(3), fits(3), few, few}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), fits(3), few, few, few}).fit_nowhere());
  EXPECT_FALSE(after({fits(3), few, fits(3)}).fit_nowhere()) << "not in a row";
}

}  // namespace
}  // namespace covis
