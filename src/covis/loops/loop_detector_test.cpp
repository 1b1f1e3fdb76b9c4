// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_detector.h"

#include <gmock/gmock.h>

#include "covis/loops/test_loop_scene.h"

namespace covis {
namespace {

using testing::Contains;
using testing::IsEmpty;

TEST(LoopDetector, FindsThePlaceAgain) {
  LoopScene loop;
  loop.go_around();
  const auto map = loop.world.shared.read();
  const std::vector<KeyFrameId> places = LoopDetector().candidates(*map, loop.current);
  ASSERT_FALSE(places.empty());
  EXPECT_LE(places.size(), LoopDetector::kCandidates);
  EXPECT_LT(map->at(places.front()).serial, 8u) << "one of the first";
}

TEST(LoopDetector, ThereIsNoneWhileTheCameraGoesOn) {
  LoopScene loop;
  loop.world.add_key_frames(30);
  const auto map = loop.world.shared.read();
  for (const KeyFrameId& id : loop.world.frames) EXPECT_THAT(LoopDetector().candidates(*map, id), IsEmpty());
}

TEST(LoopDetector, APlaceMappedAMomentAgoIsNone) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(2);
  for (uint32_t k = 1; k < LoopDetector::kBetweenLoops + 2; ++k) {
    world.forget_points();
    world.add(scene.T_cw(0));
    const auto map = world.shared.read();
    const std::vector<KeyFrameId> places = LoopDetector().candidates(*map, world.frames.back());
    for (const KeyFrameId& place : places)
      EXPECT_GE(map->at(world.frames.back()).serial, map->at(place).serial + LoopDetector::kBetweenLoops);
    if (k + 1 < LoopDetector::kBetweenLoops) {
      EXPECT_THAT(places, IsEmpty());
    }
  }
}

// Two steps along the covisibility graph lie places that look most alike: the wall behind the camera's last metres.
TEST(LoopDetector, FarPlacesComeBeforeNearOnes) {
  LoopScene loop;
  loop.world.memory = 2;  // so that covisibility ends soon
  loop.go_around(12);
  const auto map = loop.world.shared.read();
  const std::vector<KeyFrameId> places = LoopDetector().candidates(*map, loop.current);
  ASSERT_FALSE(places.empty());
  EXPECT_LT(map->at(places.front()).serial, 24u) << "of the first round";
  for (size_t a = 0; a < places.size(); ++a) {
    for (size_t b = a + 1; b < places.size(); ++b)
      EXPECT_LT(map->weight(places[a], places[b]), kCovisibilityThreshold) << "each place once";
  }
}

TEST(LoopDetector, AnotherSubmapsPlaceMayBeNew) {
  LoopScene loop;
  loop.go_twice(4, SE3());
  const auto map = loop.world.shared.read();
  EXPECT_THAT(LoopDetector().candidates(*map, loop.current), Contains(loop.world.frames[3]));
}

// A camera may cross an old map within a few key frames.
TEST(LoopDetector, AnotherSubmapsPlaceIsLookedForRightAfterALoop) {
  LoopScene loop;
  loop.go_twice(4, SE3());
  const auto map = loop.world.shared.read();
  LoopDetector detector;
  detector.recognised(map->at(loop.current).serial - 1);
  EXPECT_THAT(detector.candidates(*map, loop.current), Contains(loop.world.frames[3]));
}

TEST(LoopDetector, KeepsAwayFromTheLastLoopUntilItIsReset) {
  LoopScene loop;
  loop.go_around();
  const auto map = loop.world.shared.read();
  const uint32_t serial = map->at(loop.current).serial;
  LoopDetector detector;
  detector.recognised(serial - LoopDetector::kBetweenLoops + 1);
  EXPECT_THAT(detector.candidates(*map, loop.current), IsEmpty());
  detector.reset();
  EXPECT_FALSE(detector.candidates(*map, loop.current).empty());
  detector.recognised(serial - LoopDetector::kBetweenLoops);
  EXPECT_FALSE(detector.candidates(*map, loop.current).empty());
}

TEST(LoopDetector, AKeyFrameThatIsGoneHasNone) {
  LoopScene loop;
  loop.go_around();
  EXPECT_THAT(LoopDetector().candidates(*loop.world.shared.read(), {}), IsEmpty());
}

}  // namespace
}  // namespace covis
