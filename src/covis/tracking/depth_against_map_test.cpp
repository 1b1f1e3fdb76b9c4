// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/depth_against_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "covis/core/random.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

// A frame that shows points of a map at its true pose, and its features with another depth.
class DepthAgainstMapTest : public testing::Test {
 protected:
  DepthAgainstMapTest() {
    camera.bf = 100;  // precise up to 10 m: the whole wall
    world.add_key_frames(4);
    frame = frame_of(view, scene.T_cw(3));
    match_points(frame, view, world);
  }
  template <class Edit>
  DepthAgainstMap with(Edit&& edit_depth) {
    const PointScene::View other = edited(view, [&](Features& f) {
      for (float& depth : f.depth) {
        if (depth > 0) depth = edit_depth(depth);
      }
    });
    return comparer.compare(frame, *other.features, camera);
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  const PointScene::View view = scene.view(scene.T_cw(3));
  TrackedFrame frame;
  Pinhole camera = scene.camera;
  DepthComparer comparer;
};

TEST_F(DepthAgainstMapTest, RightDepthAgrees) {
  const DepthAgainstMap found = with([](float z) { return z; });
  EXPECT_GT(found.points, 100);
  EXPECT_LT(found.error, 0.001);
  EXPECT_TRUE(found.agrees());
  EXPECT_FALSE(found.contradicts());
  EXPECT_FALSE(found.is_suspicious());
}

TEST_F(DepthAgainstMapTest, AnotherScaleContradicts) {
  const DepthAgainstMap found = with([](float z) { return z * 1.1f; });
  EXPECT_NEAR(found.error, std::log(1.1), 0.001);
  EXPECT_TRUE(found.contradicts());
  EXPECT_FALSE(found.agrees());
}

TEST_F(DepthAgainstMapTest, DepthOfSomethingElseContradicts) {
  EXPECT_TRUE(with([](float z) { return 12 - z; }).contradicts());
  EXPECT_TRUE(with([](float) { return 6.0f; }).contradicts());
}

TEST_F(DepthAgainstMapTest, BetweenBothItIsNeither) {
  camera.bf = 400;
  const DepthAgainstMap found = with([](float z) { return z * 1.035f; });
  EXPECT_FALSE(found.contradicts());
  EXPECT_FALSE(found.agrees());
  EXPECT_TRUE(found.is_suspicious());
}

// A pair whose depths have a sigma of 3 to 5 % has errors of 5 % as a rule.
TEST_F(DepthAgainstMapTest, NoiseIsNoContradiction) {
  camera.bf = 60;
  Random random(1);
  const auto noisy = [&](float z) { return z * static_cast<float>(std::exp(0.08 * random.normal())); };
  const DepthAgainstMap found = with(noisy);
  EXPECT_GT(found.error, 0.045);
  EXPECT_FALSE(found.contradicts());
  EXPECT_TRUE(with([](float z) { return z * 1.5f; }).contradicts());
}

// Its noise is not all that a depth camera errs by: in quick turns depth and image differ by the time between them.
TEST_F(DepthAgainstMapTest, ADepthCameraHasToErrByMoreThanItsNoise) {
  camera.depth_noise = {0, 0.0015};  // 0.9 % at 6 m
  EXPECT_FALSE(with([](float z) { return z * 1.08f; }).contradicts());
  EXPECT_TRUE(with([](float z) { return z * 1.5f; }).contradicts());
}

TEST_F(DepthAgainstMapTest, AFewWrongDepthsAreNoContradiction) {
  int n = 0;
  EXPECT_TRUE(with([&](float z) { return n++ % 3 == 0 ? 5 * z : z; }).agrees());
}

TEST_F(DepthAgainstMapTest, FewDepthsSayNothing) {
  int n = 0;
  const DepthAgainstMap found = with([&](float z) { return n++ < 5 ? 2 * z : 0; });
  EXPECT_EQ(found.points, 5);
  EXPECT_FALSE(found.contradicts());
  EXPECT_FALSE(found.agrees());
}

TEST_F(DepthAgainstMapTest, FewerDepthsHaveToContradictMore) {
  camera.bf = 400;
  const auto of = [&](int count, float factor) {
    int n = 0;
    return with([&](float z) { return n++ < count ? factor * z : 0; });
  };
  const auto of_fifty = [&](float factor) { return of(50, factor); };
  EXPECT_TRUE(with([](float z) { return z * 1.06f; }).contradicts());
  EXPECT_FALSE(of_fifty(1.06f).contradicts());
  EXPECT_TRUE(of_fifty(1.12f).contradicts());
  EXPECT_FALSE(of(20, 1.12f).contradicts());
  EXPECT_TRUE(of(20, 1.5f).contradicts());
  EXPECT_TRUE(of(6, 1.5f).contradicts());
}

// Half a pixel of disparity is 5 % of the depth at 1 m here.
TEST_F(DepthAgainstMapTest, PointsTooFarToMeasureAreLeftOut) {
  camera.bf = 10;
  const DepthAgainstMap found = with([](float z) { return z; });
  EXPECT_EQ(found.points, 0);
  EXPECT_FALSE(found.agrees());
}

// ---- A map that images alone went on with ----

// Compares depth that is `edit` times the right one with a map whose points this sensor made.
template <class Edit>
DepthAgainstMap against_map_of(Sensor sensor, Edit&& edit) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene, sensor);
  world.add_key_frames(4);
  const PointScene::View measured = edited(scene.view(scene.T_cw(3)), [&](Features& f) {
    for (float& depth : f.depth) {
      if (depth > 0) depth *= edit(depth);
    }
  });
  TrackedFrame frame = frame_of(measured, scene.T_cw(3));
  match_points(frame, measured, world);
  Pinhole camera = scene.camera;
  camera.bf = 100;
  const auto map = world.shared.read();
  return DepthComparer().compare(frame, *measured.features, camera, &*map);
}

TEST(DepthOfAMapOfImages, DiffersByDriftWhereTheShapeIsRight) {
  const auto drifted = [](float) { return 1.2f; };
  const DepthAgainstMap found = against_map_of(Sensor::monocular, drifted);
  ASSERT_TRUE(found.shape);
  EXPECT_EQ(found.shape->of_depth, 0);
  EXPECT_GT(found.shape->relief, 0.1);
  EXPECT_LT(found.shape->error, 0.001);
  EXPECT_TRUE(found.contradicts());
  EXPECT_TRUE(found.differs_by_drift(2));
  EXPECT_FALSE(found.differs_by_drift(1)) << "no map drifts so far in a second: depth may have another scale";
  EXPECT_FALSE(against_map_of(Sensor::monocular, [](float) { return 1.5f; }).differs_by_drift(60)) << "too far";
  EXPECT_FALSE(against_map_of(Sensor::monocular, [](float z) { return (12 - z) / z; }).differs_by_drift(2))
      << "another shape";
  EXPECT_FALSE(against_map_of(Sensor::rgbd, drifted).differs_by_drift(2)) << "depth made that map: it has a scale";
}

TEST(DepthRemover, LeavesTheImage) {
  const PointScene scene = PointScene::wall();
  const PointScene::View view = scene.view(scene.T_cw(0));
  DepthRemover remover;
  const FeaturesPtr image = remover.without_depth(*view.features);
  ASSERT_EQ(image->size(), view.features->size());
  EXPECT_TRUE(std::equal(image->x.begin(), image->x.end(), view.features->x.begin()));
  EXPECT_TRUE(std::equal(image->descriptor.begin(), image->descriptor.end(), view.features->descriptor.begin()));
  for (int i = 0; i < image->size(); ++i) EXPECT_FALSE(image->has_depth(i));
}

constexpr DepthAgainstMap kAgrees{100, 0.01, 1}, kContradicts{100, 0.2, 20}, kUnclear{20, 0.2, 20},
    kBetween{100, 0.035, 4};

TEST(DepthBelief, AContradictionLastsUntilDepthAgreesForThreeFrames) {
  DepthBelief belief;
  EXPECT_FALSE(belief.contradicts());
  Timestamp now = 0;
  for (const DepthAgainstMap& found : {kContradicts, kAgrees, kAgrees, kUnclear, kAgrees, kAgrees, kBetween, kAgrees})
    belief.judge(found, ++now);
  EXPECT_TRUE(belief.contradicts());
  belief.judge(kAgrees, ++now);
  EXPECT_TRUE(belief.contradicts());
  belief.judge(kAgrees, ++now);
  EXPECT_FALSE(belief.contradicts());
}

// The seconds that a contradiction has to last in a map that depth agreed with for so many seconds.
double seconds_to_blame(std::optional<double> agreed) {
  DepthBelief belief;
  if (agreed) belief.begin(0);
  const Timestamp start = from_seconds(agreed.value_or(50));
  for (int tenths = 0; tenths < 100; ++tenths) {
    const Timestamp now = start + from_seconds(0.1 * tenths);
    belief.judge(kContradicts, now);
    if (belief.blames_map(now)) return 0.1 * tenths;
  }
  return -1;
}

TEST(DepthBelief, TheMapIsBelievedAsLongAsDepthAgreedWithIt) {
  EXPECT_NEAR(seconds_to_blame(1), 1, 0.15);
  EXPECT_NEAR(seconds_to_blame(0.1), 0.5, 0.15) << "half a second at least";
  EXPECT_NEAR(seconds_to_blame(60), 2, 0.15) << "and two at most";
  EXPECT_NEAR(seconds_to_blame(std::nullopt), 2, 0.15) << "a map that was loaded";
}

TEST(DepthBelief, FewDepthsBlameNoMap) {
  DepthBelief belief;
  belief.judge(kContradicts, 0);
  belief.judge(kUnclear, from_seconds(5));
  EXPECT_TRUE(belief.contradicts());
  EXPECT_FALSE(belief.blames_map(from_seconds(5)));
}

TEST(DepthBelief, ANewMapBeginsInAgreement) {
  DepthBelief belief;
  belief.judge(kContradicts, 0);
  belief.begin(from_seconds(3));
  EXPECT_FALSE(belief.contradicts());
  EXPECT_FALSE(belief.blames_map(from_seconds(9)));
}

TEST(DepthBelief, AMapBegunUponAContradictionIsOnProbation) {
  DepthBelief belief;
  belief.begin(0);
  EXPECT_FALSE(belief.is_on_probation(1)) << "nothing contradicted";
  belief.judge(kContradicts, from_seconds(1));
  belief.judge(kContradicts, from_seconds(2.9));
  belief.begin(from_seconds(3));
  EXPECT_TRUE(belief.is_on_probation(from_seconds(4)));
  belief.begin(from_seconds(4));  // the camera was lost
  EXPECT_TRUE(belief.is_on_probation(from_seconds(4.9)));
  EXPECT_FALSE(belief.is_on_probation(from_seconds(5))) << "two seconds from the doubt, however often it is lost";
  belief.judge(kContradicts, from_seconds(7));
  belief.begin(from_seconds(8));
  EXPECT_FALSE(belief.is_on_probation(from_seconds(8.1))) << "the camera was lost long before";
}

TEST(DepthBelief, ProbationEndsWhereDepthProvesRight) {
  DepthBelief belief;
  belief.begin(0);
  belief.judge(kContradicts, from_seconds(2.9));
  belief.begin(from_seconds(3));
  EXPECT_EQ(belief.probation_since(from_seconds(4)), from_seconds(3));
  belief.begin(from_seconds(3.5));
  EXPECT_EQ(belief.probation_since(from_seconds(4)), from_seconds(3.5)) << "the present map";
  belief.judge(kContradicts, from_seconds(4));
  belief.trust_depth();
  EXPECT_TRUE(belief.is_on_probation(from_seconds(4))) << "the map was made of other depth";
  belief.begin(from_seconds(4.2));
  belief.trust_depth();
  EXPECT_FALSE(belief.is_on_probation(from_seconds(4.3)));
  EXPECT_EQ(belief.probation_since(from_seconds(4.3)), std::nullopt);
}

TEST(DepthBelief, AMapThatDriftedIsLeftAtOnce) {
  DepthAgainstMap drifted = kContradicts;
  drifted.error = 0.07;
  drifted.shape = {.of_depth = 0, .error = 0.01, .relief = 0.2};
  ASSERT_TRUE(drifted.contradicts() && drifted.differs_by_drift(0));
  DepthBelief belief;
  belief.begin(0);
  const auto now = [](int frame) { return from_seconds(10 + frame / 30.0); };
  belief.judge(kContradicts, now(0));
  belief.judge(drifted, now(1));
  belief.judge(kContradicts, now(2));  // the map could not be read
  belief.judge(drifted, now(3));
  EXPECT_FALSE(belief.blames_map(now(3)));
  belief.judge(kAgrees, now(3));
  belief.judge(drifted, now(3));
  belief.judge(drifted, now(3));
  EXPECT_FALSE(belief.blames_map(now(3))) << "not in a row";
  belief.judge(drifted, now(4));
  EXPECT_TRUE(belief.blames_map(now(4)));
  belief.judge(DepthAgainstMap{}, now(4));
  EXPECT_FALSE(belief.blames_map(now(4))) << "nothing to compare";
  for (int k = 0; k < 3; ++k) belief.judge(drifted, now(4));
  EXPECT_TRUE(belief.blames_map(now(4)));
  belief.begin(now(5));
  EXPECT_FALSE(belief.blames_map(now(5)));
  EXPECT_FALSE(belief.is_on_probation(now(5))) << "motion has said that depth is right";
  belief.judge(kContradicts, now(6));
  belief.begin(now(7));
  EXPECT_TRUE(belief.is_on_probation(now(7)));
}

TEST(DepthBelief, AnOlderMapIsNotOnProbation) {
  DepthBelief belief;
  belief.begin(0);
  const auto features = std::make_shared<const Features>();
  TrackedFrame frame;
  frame.features = belief.receive(features);
  belief.judge(kContradicts, from_seconds(2.9));
  belief.begin(from_seconds(3));
  ASSERT_TRUE(belief.is_on_probation(from_seconds(4)));
  belief.judge(kContradicts, from_seconds(3.9));
  belief.change_map(frame);
  EXPECT_FALSE(belief.is_on_probation(from_seconds(4)));
  EXPECT_FALSE(belief.contradicts()) << "found by its depth as well";

  belief.judge(kContradicts, from_seconds(5));
  frame.features = belief.receive(features);
  belief.change_map(frame);
  EXPECT_TRUE(belief.contradicts()) << "found by its image alone";
  frame.stamp = from_seconds(8);
  belief.change_map(frame);
  belief.judge(kContradicts, from_seconds(8.1));
  EXPECT_FALSE(belief.blames_map(from_seconds(8.1))) << "what contradicted another map says nothing of this one";
}

}  // namespace
}  // namespace covis
