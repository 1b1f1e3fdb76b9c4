// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/match_belief.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

TrackFigures seen(double local_share, double first_share) {
  TrackFigures figures;
  figures.local_expected = 1000;
  figures.inliers = static_cast<int>(1000 * local_share);
  figures.first_share = first_share;
  return figures;
}

TEST(MatchBelief, APoseThatMatchesAsUsualIsBelieved) {
  MatchBelief belief;
  for (int i = 0; i < 50; ++i) belief.accept(seen(0.67, 0.55));
  EXPECT_TRUE(belief.explains_view(seen(0.6, 0.5), false));
  EXPECT_TRUE(belief.explains_view(seen(0.3, 0.1), false)) << "the local map alone";
  EXPECT_TRUE(belief.explains_view(seen(0.1, 0.3), false)) << "the last frame alone";
}

TEST(MatchBelief, MatchesByChanceAreNotBelieved) {
  MatchBelief belief;
  for (int i = 0; i < 50; ++i) belief.accept(seen(0.67, 0.55));
  EXPECT_FALSE(belief.explains_view(seen(0.13, 0.12), false));
  EXPECT_FALSE(belief.explains_view(seen(0.05, 0.0), true)) << "not even when the images agree";
}

TEST(MatchBelief, FewerMatchesThanUsualAreNoticed) {
  MatchBelief belief;
  for (int i = 0; i < 100; ++i) belief.accept(seen(0.6, 0.55));
  EXPECT_FALSE(belief.is_short(seen(0.55, 0.1)));
  EXPECT_TRUE(belief.is_short(seen(0.4, 0.55)));
}

TEST(MatchBelief, LessThanHalfOfWhatIsUsualIsWeak) {
  MatchBelief belief;
  for (int i = 0; i < 100; ++i) belief.accept(seen(0.6, 0.55));
  EXPECT_FALSE(belief.is_weak(seen(0.35, 0)));
  EXPECT_TRUE(belief.is_weak(seen(0.25, 0.55)));
}

TEST(MatchBelief, ABlurredImageIsBelievedWhenTheImagesAgree) {
  MatchBelief belief;
  for (int i = 0; i < 50; ++i) belief.accept(seen(0.43, 0.44));
  EXPECT_FALSE(belief.explains_view(seen(0.1, 0.12), false));
  EXPECT_TRUE(belief.explains_view(seen(0.1, 0.12), true));
}

TEST(MatchBelief, FewMatchesAreBelievedWhereTheyAreUsual) {
  MatchBelief belief;
  EXPECT_FALSE(belief.explains_view(seen(0.12, 0.12), false));
  for (int i = 0; i < 100; ++i) belief.accept(seen(0.2, 0.24));
  EXPECT_TRUE(belief.explains_view(seen(0.12, 0.05), false));
  for (int i = 0; i < 1000; ++i) belief.accept(seen(0.01, 0.01));
  EXPECT_FALSE(belief.explains_view(seen(0.05, 0.05), false)) << "chance is never usual";
}

}  // namespace
}  // namespace covis
