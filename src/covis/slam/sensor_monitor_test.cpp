// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/sensor_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "covis/features/test_features.h"
#include "covis/slam/map_camera.h"
#include "covis/tracking/test_frames.h"

namespace covis {
namespace {

using testing::HasSubstr;

// Features of which a share has a disparity, which differs by up to a share of `relief` between them.
Features features(double share, double disparity, double relief = 0.1) {
  Random random(1);
  Features f = no_features();
  for (int i = 0; i < 200; ++i) {
    const double x = random.uniform(100, 600);
    const double own = disparity * random.uniform(1 - relief / 2, 1 + relief / 2);
    add(f, {.x = x, .y = random.uniform(0, 480), .u_right = i < 200 * share ? x - own : -1});
  }
  finish(f);
  return f;
}

std::vector<SensorWarning> warnings_of(Sensor sensor, const Features& f, double row_error, int frames = 20) {
  SensorMonitor monitor(sensor);
  for (int i = 0; i < frames; ++i) monitor.add_frame(i, f, row_error);
  EXPECT_FALSE(monitor.doubts() && frames < 20);
  return monitor.take_warnings();
}

TEST(SensorMonitor, AGoodPairIsBelieved) {
  EXPECT_TRUE(warnings_of(Sensor::stereo, features(0.4, 10), 0.4).empty());
  EXPECT_TRUE(warnings_of(Sensor::rgbd, features(0.4, 10), 0).empty());
}

TEST(SensorMonitor, FewMatches) {
  const auto warnings = warnings_of(Sensor::stereo, features(0.1, 10), 0.4);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::few_depths);
  EXPECT_EQ(warnings[0].frame, 19) << "not of the first frames alone";
  EXPECT_THAT(describe(warnings[0], Sensor::stereo), HasSubstr("only 10 % of the left keypoints"));
  EXPECT_TRUE(warnings_of(Sensor::stereo, features(0.1, 10), 0.4, 10).empty());
}

// Keypoints beyond the usual number are worse ones.
TEST(SensorMonitor, FewMatchesOfTwiceTheKeypointsAreNoFault) {
  SensorMonitor monitor(Sensor::stereo);
  const Features few = features(0.1, 10);
  for (int i = 0; i < 40; ++i) monitor.add_frame(i, few, 0.4, SensorMonitor::Budget::doubled);
  EXPECT_TRUE(monitor.take_warnings().empty());
  for (int i = 40; i < 60; ++i) monitor.add_frame(i, few, 0.4);
  EXPECT_TRUE(monitor.doubts());
}

// The images still show where the camera is.
TEST(SensorMonitor, FewDepthsOfADepthCameraAreToldAndLeavePosesSure) {
  SensorMonitor monitor(Sensor::rgbd);
  for (int i = 0; i < 20; ++i) monitor.add_frame(i, features(0.02, 10), 0);
  const auto warnings = monitor.take_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::few_depths);
  EXPECT_FALSE(monitor.doubts());
  EXPECT_FALSE(monitor.doubts_depth());
  EXPECT_FALSE(monitor.suspects_depth());
}

TEST(SensorMonitor, OneImageTwice) {
  const auto warnings = warnings_of(Sensor::stereo, features(0.5, 0.05), 0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::no_disparity);
  EXPECT_THAT(describe(warnings[0], Sensor::stereo), HasSubstr("100 %"));
}

TEST(SensorMonitor, AFarSceneIsNotOneImage) {
  EXPECT_TRUE(warnings_of(Sensor::stereo, features(0.5, 0.5), 0.3).empty());
  EXPECT_TRUE(warnings_of(Sensor::stereo, features(0.5, 0.05), 0.3).empty()) << "rows of two cameras differ";
}

TEST(SensorMonitor, RowsThatDiffer) {
  const auto warnings = warnings_of(Sensor::stereo, features(0.4, 10), 1.0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::rows_differ);
}

// 40 / 400: a tenth of a metre.
TEST(SensorMonitor, DepthsNearerThanCamerasSee) {
  const auto warnings = warnings_of(Sensor::rgbd, features(0.6, 400), 0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::depth_too_near);
  EXPECT_THAT(describe(warnings[0], Sensor::rgbd), HasSubstr("depth_scale"));
}

TEST(SensorMonitor, ImagesOfOneValueAreNoDepth) {
  const auto warnings = warnings_of(Sensor::rgbd, features(0.6, 10, 0), 0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::no_relief);
  EXPECT_THAT(describe(warnings[0], Sensor::rgbd), HasSubstr("the same depth"));
  EXPECT_TRUE(warnings_of(Sensor::rgbd, features(0.6, 10, 0.01), 0).empty()) << "a wall";
  for (const SensorWarning& warning : warnings_of(Sensor::rgbd, features(0.02, 10, 0), 0))
    EXPECT_NE(warning.doubt, SensorDoubt::no_relief) << "a few near things";
  SensorMonitor monitor(Sensor::rgbd);
  for (int i = 0; i < 20; ++i) monitor.add_frame(i, features(0.6, 10, 0), 0);
  EXPECT_TRUE(monitor.doubts());
  for (int i = 20; i < 40; ++i) monitor.add_frame(i, features(0.6, 10), 0);
  EXPECT_FALSE(monitor.doubts());
}

TEST(SensorMonitor, DoubtsOfFramesEndWhereFramesSayNothing) {
  for (const Features& silent : {no_features(), features(0, 10)}) {
    SensorMonitor monitor(Sensor::stereo);
    for (int i = 0; i < 20; ++i) monitor.add_frame(i, features(0.4, 10), 1.0);
    EXPECT_TRUE(monitor.doubts());
    for (int i = 20; i < 39; ++i) monitor.add_frame(i, silent, 0);
    EXPECT_TRUE(monitor.doubts()) << "a few frames without are no answer";
    monitor.add_frame(39, silent, 0);
    EXPECT_EQ(monitor.doubts(), silent.size() > 0) << "without matches another doubt follows";
    monitor.take_warnings();
    for (int i = 40; i < 60; ++i) monitor.add_frame(i, features(0.4, 10), 0.4);
    EXPECT_FALSE(monitor.doubts());
  }
}

TEST(SensorMonitor, ContradictionsAreDoubtedUntilTheyEnd) {
  const DepthAgainstMotion wrong{100, 0.4, 0.3}, right{100, 0.03, 0.3};
  SensorMonitor monitor(Sensor::rgbd);
  for (int k = 0; k < 2; ++k) monitor.add_comparison(k, wrong);
  EXPECT_FALSE(monitor.doubts()) << "few comparisons";
  monitor.add_comparison(2, wrong);
  EXPECT_TRUE(monitor.doubts());
  const auto warnings = monitor.take_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NEAR(warnings[0].figure, 1.33, 0.01);
  EXPECT_THAT(describe(warnings[0], Sensor::rgbd), HasSubstr("1.33"));
  for (int k = 0; k < 3; ++k) monitor.add_comparison(5 + k, right);
  EXPECT_FALSE(monitor.doubts());
  for (int k = 0; k < 5; ++k) monitor.add_comparison(8 + k, wrong);
  EXPECT_TRUE(monitor.doubts());
  EXPECT_TRUE(monitor.take_warnings().empty()) << "reported once";
  for (int k = 0; k < 5; ++k) monitor.add_comparison(13 + k, right);
  EXPECT_FALSE(monitor.doubts());
  EXPECT_TRUE(monitor.suspects_depth()) << "what was wrong once is looked at more often for good";
}

// Where all is known no key frame is made, so that no comparison of key frames ends a doubt.
class DoubtedFrames : public testing::Test {
 protected:
  static FeaturesPtr with_depth(int k, float (*depth_of)(float)) {
    auto seen = std::make_shared<Features>(*frames().features(k));
    for (float& depth : seen->depth) depth = depth_of(depth);
    return seen;
  }
  static float right(float depth) { return depth; }
  static float inverse(float depth) { return depth > 0 ? 1 / depth : depth; }
  // The number of frames, each seen `repeats` times in its time, after which the doubt ends.
  static int doubted_for(float (*depth_of)(float), int repeats) {
    SensorMonitor monitor(Sensor::rgbd);
    for (int k = 0; k < 3; ++k) monitor.add_comparison(k, {100, 0.4, 0.3});
    EXPECT_TRUE(monitor.doubts());
    for (int k = 0; k < frames().count(); ++k) {
      const Timestamp step = (frames().stamp(1) - frames().stamp(0)) / repeats;
      for (int i = 0; i < repeats; ++i) {
        monitor.add_view(1 + 3 * (k * repeats + i), frames().stamp(k) + i * step, with_depth(k, depth_of), camera());
        if (!monitor.doubts()) return k;
      }
    }
    return frames().count();
  }
  // The number of frames after which depth is said to be right of a map on probation.
  static int probation_for(float (*depth_of)(float)) {
    SensorMonitor monitor(Sensor::rgbd);
    for (int k = 0; k < 5; ++k) monitor.add_comparison(k, {100, 0.03, 0.3});
    for (int k = 0; k < frames().count(); ++k) {
      monitor.add_map_trust(SensorMonitor::MapTrust::on_probation);
      const bool is_right = monitor.add_view(k, frames().stamp(k), with_depth(k, depth_of), camera());
      EXPECT_FALSE(monitor.doubts()) << "what is asked of a map makes no doubt";
      if (is_right) return k;
    }
    return frames().count();
  }
  static TestFrames& frames() { return TestFrames::of(Sensor::rgbd); }
  static Pinhole camera() { return for_sensor(frames().camera(), Sensor::rgbd); }
};

TEST_F(DoubtedFrames, EndTheDoubtWhereDepthIsRightAgain) { EXPECT_LT(doubted_for(right, 1), 20); }

TEST_F(DoubtedFrames, EndItAlikeAtAnyRate) {
  EXPECT_NEAR(doubted_for(right, 8), doubted_for(right, 1), 4) << "64 frames a second and 8";
}

TEST_F(DoubtedFrames, KeepItWhereDepthIsWrong) {
  EXPECT_EQ(doubted_for(inverse, 1), frames().count());
  const auto compared = compare_depth_with_motion(*with_depth(0, inverse), *with_depth(8, inverse), camera(), 0);
  ASSERT_TRUE(compared) << "no comparison could have ended the doubt";
  EXPECT_GT(compared->error(), 0.6);
}

TEST_F(DoubtedFrames, TellThatDepthOfAMapOnProbationIsRight) {
  EXPECT_LT(probation_for(right), 12) << "before two seconds are over";
  EXPECT_EQ(probation_for(inverse), frames().count());
}

// A slow camera makes few key frames: reversed depth was believed for all of six seconds.
TEST_F(DoubtedFrames, BeginTheDoubtInTheFirstSecondsWithoutAKeyFrame) {
  const auto doubted_after = [](float (*depth_of)(float)) {
    SensorMonitor monitor(Sensor::rgbd);
    for (int k = 0; k < frames().count(); ++k) {
      monitor.add_view(k, frames().stamp(k), with_depth(k, depth_of), camera());
      if (monitor.doubts()) return k;
    }
    return frames().count();
  };
  EXPECT_LT(doubted_after(inverse), 16) << "two seconds";
  EXPECT_EQ(doubted_after(right), frames().count());
}

TEST_F(DoubtedFrames, AreNotComparedAfterTheFirstSeconds) {
  SensorMonitor monitor(Sensor::rgbd);
  const auto later = [](int k) { return frames().stamp(k) + (k > 0 ? from_seconds(6) : 0); };
  for (int k = 0; k < frames().count(); ++k) monitor.add_view(k, later(k), with_depth(k, inverse), camera());
  EXPECT_FALSE(monitor.doubts()) << "key frames tell";
}

TEST_F(DoubtedFrames, SayNothingOfAMapThatIsOnNoProbation) {
  SensorMonitor monitor(Sensor::rgbd);
  for (int k = 0; k < frames().count(); ++k)
    EXPECT_FALSE(monitor.add_view(k, frames().stamp(k), with_depth(k, right), camera()));
}

// Two motions in a row that are wrong, in a long recording whose depth is right.
TEST(SensorMonitor, FewContradictionsAmongManyAgreementsAreNoFault) {
  SensorMonitor monitor(Sensor::rgbd);
  int k = 0;
  for (; k < 5; ++k) monitor.add_comparison(k, {100, 0.03, 0.3});
  for (; k < 7; ++k) monitor.add_comparison(k, {100, 0.6, 0.3});
  monitor.add_comparison(k++, {100, 0.03, 0.3});
  monitor.add_comparison(k++, {100, 0.03, 0.3});
  EXPECT_FALSE(monitor.doubts());
  for (; k < 12; ++k) monitor.add_comparison(k, {100, 0.6, 0.3});
  ASSERT_TRUE(monitor.doubts());
  EXPECT_NEAR(monitor.take_warnings().at(0).figure, 2, 1e-9) << "the figure of the rule that doubts";
}

TEST(SensorMonitor, TheFigureIsOfTheFewThatWereCompared) {
  SensorMonitor monitor(Sensor::rgbd);
  monitor.add_comparison(0, {100, 0.03, 0.3});
  for (int k = 1; k < 4; ++k) monitor.add_comparison(k, {100, 0.3 + 0.15 * k, 0.3});
  ASSERT_TRUE(monitor.doubts());
  EXPECT_NEAR(monitor.take_warnings().at(0).figure, 1.5, 1e-9) << "of 0.1, 1.5 and 2";
}

TEST(SensorMonitor, LittleBetterThanAConstantTakesMoreComparisons) {
  SensorMonitor monitor(Sensor::rgbd);
  for (int k = 0; k < 4; ++k) monitor.add_comparison(k, {100, 0.3, 0.3});
  EXPECT_FALSE(monitor.doubts());
  monitor.add_comparison(4, {100, 0.3, 0.3});
  EXPECT_TRUE(monitor.doubts());
}

// The triangulation may be wrong, not depth.
TEST(SensorMonitor, WhatDepthExplainsIsNoContradiction) {
  SensorMonitor monitor(Sensor::rgbd);
  for (int k = 0; k < 10; ++k) monitor.add_comparison(k, {100, 0.4, 0.2, 0.7});
  EXPECT_FALSE(monitor.doubts());
}

// A flat wall: a constant depth is as good as any.
TEST(SensorMonitor, AFlatSceneIsNoContradiction) {
  SensorMonitor monitor(Sensor::rgbd);
  for (int k = 0; k < 10; ++k) monitor.add_comparison(k, {100, 0.03, 0.02});
  EXPECT_FALSE(monitor.doubts());
}

TEST(SensorMonitor, OneCameraHasNoDepthToDoubt) {
  EXPECT_TRUE(warnings_of(Sensor::monocular, features(0, 10), 0).empty());
}

TEST(SensorMonitor, ADoubtOfDepthIsNotEndedByPointsThatChanceExplains) {
  SensorMonitor monitor(Sensor::rgbd);
  for (int i = 0; i < 5; ++i) monitor.add_comparison(i, {100, 0.4, 0.1, 0.3});
  ASSERT_TRUE(monitor.doubts_depth());
  for (int i = 5; i < 15; ++i) monitor.add_comparison(i, {40, 0.4, 0.1, 0.7});
  EXPECT_TRUE(monitor.doubts_depth());
  for (int i = 15; i < 18; ++i) monitor.add_comparison(i, {40, 0.02, 0.1, 0.9});
  EXPECT_FALSE(monitor.doubts_depth());
}

TEST(SensorMonitor, DepthThatContradictsTheMapIsToldAfterFiveFrames) {
  SensorMonitor monitor(Sensor::rgbd);
  for (int i = 0; i < 20; ++i) monitor.add_map_comparison(i, i % 5 != 4 ? 0.2 : 0);
  EXPECT_TRUE(monitor.take_warnings().empty());
  for (int i = 20; i < 25; ++i) monitor.add_map_comparison(i, 0.2);
  const auto warnings = monitor.take_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::depth_against_map);
  EXPECT_EQ(warnings[0].frame, 24);
  EXPECT_THAT(describe(warnings[0], Sensor::rgbd), HasSubstr("by 0.20 in the median"));
  EXPECT_FALSE(monitor.doubts()) << "tracking itself calls these poses tentative";
}

TEST(SensorMonitor, OutlinesThatFitNowhereAreDoubtedUntilTheyFit) {
  const OutlineFit good{12, 6, 900}, nowhere{3, 5, 900};
  SensorMonitor monitor(Sensor::rgbd);
  for (const OutlineFit& fit : {good, nowhere, nowhere, good, nowhere, nowhere}) monitor.add_outlines(0, fit);
  EXPECT_FALSE(monitor.doubts()) << "never three in a row";
  monitor.add_outlines(40, nowhere);
  EXPECT_TRUE(monitor.doubts());
  EXPECT_TRUE(monitor.doubts_depth());
  EXPECT_TRUE(monitor.suspects_depth());
  const auto warnings = monitor.take_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::outlines_fit_nowhere);
  EXPECT_EQ(warnings[0].frame, 40);
  EXPECT_THAT(describe(warnings[0], Sensor::rgbd), HasSubstr("3.0 standard deviations"));
  monitor.add_outlines(60, good);
  EXPECT_FALSE(monitor.doubts());
}

// Depth images that are looked up by a registration are not asked any more, so that a doubt of before never ended.
TEST(SensorMonitor, ADoubtByOutlinesEndsWhereARegistrationIsFound) {
  const OutlineFit displaced{4, 20, 900};
  SensorMonitor monitor(Sensor::rgbd);
  for (int i = 0; i < 2; ++i) monitor.add_outlines(i, displaced);
  ASSERT_TRUE(monitor.doubts_depth());
  const ImageU8 image(64, 48);
  const ImageF depth(64, 48);
  DepthRegistration registration;
  registration.shift_x = 12;
  monitor.add_images(2, image.view(), depth.view(), registration);
  EXPECT_FALSE(monitor.doubts_depth());
}

TEST(SensorMonitor, DepthThatNoLongerChangesIsDoubtedUntilItDoes) {
  SensorMonitor monitor(Sensor::rgbd);
  constexpr int kSide = 128;
  ImageU8 image(kSide, kSide);
  ImageF depth(kSide, kSide);
  const auto add = [&](int i, float distance) {
    for (int y = 0; y < kSide; ++y) {
      std::fill_n(image.row(y), kSide, static_cast<uint8_t>((y / 20 + i) % 2 * 100));
      std::fill_n(depth.row(y), kSide, distance);
    }
    monitor.add_images(i, image.view(), depth.view());
  };
  for (int i = 0; i < 14; ++i) add(i, 2);
  EXPECT_FALSE(monitor.doubts());
  add(14, 2);
  EXPECT_TRUE(monitor.doubts());
  const auto warnings = monitor.take_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::depth_frozen);
  EXPECT_THAT(describe(warnings[0], Sensor::rgbd), HasSubstr("15 depth images in a row are the same"));
  add(15, 2.1f);
  EXPECT_FALSE(monitor.doubts());
}

TEST(SensorMonitor, TornImagesAreToldAfterTwoInARow) {
  using Rows = SensorMonitor::Rows;
  SensorMonitor monitor(Sensor::monocular);
  for (const Rows rows : {Rows::displaced, Rows::in_place, Rows::displaced}) monitor.add_rows(0, rows);
  EXPECT_TRUE(monitor.take_warnings().empty());
  monitor.add_rows(3, Rows::displaced);
  const auto warnings = monitor.take_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::images_torn);
  EXPECT_EQ(warnings[0].frame, 3);
  EXPECT_THAT(describe(warnings[0], Sensor::monocular), HasSubstr("2 images in a row"));
  EXPECT_FALSE(monitor.doubts()) << "tracking itself calls these poses tentative";
}

TEST(SensorMonitor, DisplacedDepthIsDoubtedAfterTwoAnswersAndUntilOneIsGood) {
  const OutlineFit good{20, 8, 900}, displaced{4, 20, 900};
  SensorMonitor monitor(Sensor::rgbd);
  for (const OutlineFit& fit : {displaced, good, displaced}) monitor.add_outlines(0, fit);
  EXPECT_FALSE(monitor.doubts());
  monitor.add_outlines(40, displaced);
  EXPECT_TRUE(monitor.doubts());
  EXPECT_TRUE(monitor.doubts_depth());
  const auto warnings = monitor.take_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].doubt, SensorDoubt::depth_displaced);
  EXPECT_EQ(warnings[0].frame, 40);
  EXPECT_THAT(describe(warnings[0], Sensor::rgbd), HasSubstr("5.0 times better"));
  monitor.add_outlines(60, good);
  EXPECT_FALSE(monitor.doubts());
}

}  // namespace
}  // namespace covis
