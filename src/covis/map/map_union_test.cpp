// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_union.h"

#include <gtest/gtest.h>

#include "covis/map/anchors.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

class MapUnion : public testing::Test {
 protected:
  static MapState mapped(const PointScene& scene, size_t key_frames, size_t first) {
    SceneMap world(scene);
    world.add_key_frames(key_frames, first);
    world.shared.write()->add_loop_edge(world.frames.front(), world.frames.back());
    return world.shared.read()->state();
  }

  const PointScene scene = PointScene::wall();
};

TEST_F(MapUnion, HasTheSubmapsOfBothSideBySide) {
  MapState one = mapped(scene, 4, 0);
  const MapState first = one, second = mapped(scene, 6, 8);
  ASSERT_TRUE(append_map(one, second));
  const auto both = Map::from_state(one);
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(both->check(), "");
  ASSERT_EQ(both->submaps().size(), 2u);
  EXPECT_EQ(both->submaps()[0].key_frames, 4u);
  EXPECT_EQ(both->submaps()[1].key_frames, 6u);
  EXPECT_EQ(both->point_count(), first.points.size() + second.points.size());
  EXPECT_EQ(both->next_serial(), first.next_serial + second.next_serial);
  const std::vector<KeyFrameId> frames = both->key_frames();
  for (size_t k = 0; k < 6; ++k) {
    const KeyFrame& there = both->at(frames[4 + k]);
    EXPECT_EQ(there.T_cw.t(), second.key_frames[k].T_cw.t());
    EXPECT_EQ(there.frame, second.key_frames[k].frame);
    EXPECT_EQ(there.serial, second.key_frames[k].serial + first.next_serial);
  }
  EXPECT_EQ(both->at(frames[4]).loop_edges, std::vector<KeyFrameId>{frames[9]});
}

TEST_F(MapUnion, AnchorsNameTheSameKeyFrames) {
  MapState one = mapped(scene, 4, 0), second = mapped(scene, 6, 8);
  auto features = second.key_frames[3].features->for_key_frame();
  features->anchor.resize(features->x.size(), 0);
  features->anchor[5] = anchor_at(second.key_frames[1].serial, 3);
  second.key_frames[3].features = features;
  ASSERT_TRUE(append_map(one, second));
  const AlignedVector<uint64_t>& anchor = one.key_frames[4 + 3].features->anchor;
  EXPECT_EQ(anchor[5], anchor_at(one.key_frames[4 + 1].serial, 3));
  EXPECT_EQ(anchor[6], 0u) << "what is not aligned stays so";
  EXPECT_TRUE(one.key_frames[4 + 2].features->anchor.empty());
}

TEST_F(MapUnion, AnEmptyMapAddsNothingAndGetsEverything) {
  MapState map = mapped(scene, 3, 0);
  ASSERT_TRUE(append_map(map, MapState{}));
  EXPECT_EQ(map.key_frames.size(), 3u);
  MapState empty;
  ASSERT_TRUE(append_map(empty, map));
  empty.camera = map.camera;
  const auto made = Map::from_state(empty);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->key_frame_count(), 3u);
}

TEST_F(MapUnion, SerialsThatDoNotFitAreRefused) {
  MapState map = mapped(scene, 3, 0);
  map.next_serial = MapState::kNone - 2;
  EXPECT_FALSE(append_map(map, mapped(scene, 3, 0)));
  EXPECT_EQ(map.key_frames.size(), 3u);
}

}  // namespace
}  // namespace covis
