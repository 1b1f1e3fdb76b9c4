// SPDX-License-Identifier: Apache-2.0
#include "covis/map/colours.h"

#include <gtest/gtest.h>

#include "covis/features/test_features.h"

namespace covis {
namespace {

TEST(Colours, AreThoseOfTheNearestPixelInEitherOrder) {
  // 2 x 2 pixels, rows of 7 bytes.
  const std::vector<uint8_t> bytes{1, 2, 3, 4, 5, 6, 0, 7, 8, 9, 10, 11, 12, 0};
  Features features = no_features();
  Random random(1);
  for (const double x : {0.4, 0.6, 5.0}) add(features, {x, x > 0.5 ? 1.2 : -3, 0, random_descriptor(random)});
  finish(features, {-4, -4, 6, 6});
  ColourImage image{bytes.data(), 2, 2, 7};
  EXPECT_EQ(*colours_at(features, image), (std::vector<Colour>{{1, 2, 3}, {10, 11, 12}, {10, 11, 12}}));
  image.order = ColourOrder::bgr;
  EXPECT_EQ(colours_at(features, image)->front(), (Colour{3, 2, 1}));
}

TEST(Colours, OfAPointAreTheMeanOfThoseSeen) {
  MeanColours means(2);
  means.add(1, {10, 0, 255});
  means.add(1, {13, 1, 255});
  EXPECT_EQ(means.mean(0), kNoColour);
  EXPECT_EQ(means.mean(1), (Colour{12, 1, 255})) << "rounded to the nearest";
}

}  // namespace
}  // namespace covis
