// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/pose_search.h"

#include <gtest/gtest.h>

#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

class PoseSearchTest : public testing::Test {
 protected:
  PoseSearchTest() { world.add_key_frames(12, 0, 4); }

  const PointScene scene = PointScene::ring();
  SceneMap world{scene};
  PoseSearch search{RecoveryOptions{}, Subject::stream};
};

TEST_F(PoseSearchTest, TheCameraIsTheMaps) {
  search.refresh_camera(*world.shared.read());
  EXPECT_EQ(search.camera, scene.camera);
  const Pinhole refined{400, 400, 300, 200, 0};
  world.shared.write()->set_camera(refined);
  search.refresh_camera(*world.shared.read());
  EXPECT_EQ(search.camera, refined);
}

TEST_F(PoseSearchTest, TheLocalMapLiesAroundTheMatches) {
  TrackedFrame frame = frame_of(world.views[5], scene.T_cw(20));
  match_points(frame, world.views[5], world);
  search.update_local_map(world.shared, frame, world.frames[0], 80);
  EXPECT_EQ(search.local_map.reference.id, world.frames[5]);
}

TEST_F(PoseSearchTest, WithoutMatchesOfTheMapItLiesAroundTheFallback) {
  TrackedFrame frame = frame_of(world.views[5], scene.T_cw(20));
  match_points(frame, world.views[5], world);
  search.update_local_map(world.shared, frame, {}, 80);
  for (size_t f = 0; f < frame.source.size(); ++f) frame.source[f] = PointSource::depth;
  search.update_local_map(world.shared, frame, world.frames[0], 80);
  EXPECT_EQ(search.local_map.reference.id, world.frames[0]);
}

}  // namespace
}  // namespace covis
