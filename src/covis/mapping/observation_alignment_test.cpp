// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/observation_alignment.h"

#include <gtest/gtest.h>

#include "covis/map/anchors.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

struct ObservationAlignment : testing::Test {
  static PointScene noisy_scene() {
    PointScene scene = PointScene::wall(300, 30);
    scene.noise = 0.4;
    scene.patches = true;
    return scene;
  }
  // The root mean square of by how much observations are displaced against those of their points' references, pixels of
  // their levels.
  double displacement() const {
    const auto map = world.shared.read();
    double sum = 0;
    int count = 0;
    for (const KeyFrameId& id : world.frames) {
      const KeyFrame& k = map->at(id);
      for (uint32_t i = 0; i < k.points.size(); ++i) {
        const MapPoint& point = map->at(k.points[i]);
        if (point.reference == id) continue;
        const auto off = [&](KeyFrameId view, uint32_t feature) {
          const KeyFrame& v = map->at(view);
          const Features& f = *v.features;
          const Eigen::Vector2d truth = map->camera().project(v.T_cw * point.position_w);
          return Eigen::Vector2d((Eigen::Vector2d(f.x[feature], f.y[feature]) - truth) /
                                 static_cast<double>(f.pyramid->scale[f.level[feature]]));
        };
        sum += (off(id, i) - off(point.reference, point.feature_in(point.reference))).squaredNorm();
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }

  const PointScene scene = noisy_scene();
  SceneMap world{scene};
};

TEST_F(ObservationAlignment, BringsObservationsToWhereTheirReferencesAre) {
  world.add_key_frames(6);
  const double before = displacement();
  align_observations(world.shared, world.frames.back());
  EXPECT_LT(displacement(), before / 2);
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  int aligned = 0, all = 0;
  for (const KeyFrameId& id : world.frames) {
    const KeyFrame& k = map->at(id);
    for (uint32_t i = 0; i < k.points.size(); ++i) {
      const MapPoint& point = map->at(k.points[i]);
      if (point.reference == id) continue;
      ++all;
      aligned += anchor_of(k, i) == anchor_of(map->at(point.reference), point.feature_in(point.reference));
    }
  }
  EXPECT_GT(aligned, all * 8 / 10);
}

// Nothing changes by aligning twice: what is aligned stays where it is.
TEST_F(ObservationAlignment, IsDoneOnce) {
  world.add_key_frames(4);
  align_observations(world.shared, world.frames.back());
  const AlignedVector<float> once = world.shared.read()->at(world.frames[2]).features->x;
  align_observations(world.shared, world.frames.back());
  EXPECT_EQ(world.shared.read()->at(world.frames[2]).features->x, once);
}

// Key frames that are not new keep the patches of the points whose reference they are; new ones are aligned with these.
TEST_F(ObservationAlignment, OldKeyFramesKeepFewPatches) {
  world.add_key_frames(22);
  align_observations(world.shared, world.frames.back());
  const auto map = world.shared.read();
  const KeyFrame& old = map->at(world.frames[3]);
  ASSERT_TRUE(old.features->patches);
  size_t references = 0;
  for (uint32_t i = 0; i < old.points.size(); ++i) {
    const bool is_reference = map->at(old.points[i]).reference == world.frames[3];
    references += is_reference;
    const Patch* patch = old.features->patches->find(i);
    ASSERT_EQ(patch != nullptr, is_reference);
    if (!patch) continue;
    EXPECT_EQ(patch->grey, world.views[3].features->patches->at[i].grey);
  }
  EXPECT_EQ(old.features->patches->at.size(), references);
  EXPECT_EQ(map->at(world.frames[21]).features->patches->at.size(), map->at(world.frames[21]).points.size());
  EXPECT_LT(displacement(), 0.4);
}

TEST_F(ObservationAlignment, AfterManyOthersAKeyFrameHasNone) {
  world.add_key_frames(18);
  align_observations(world.shared, world.frames.back());
  ASSERT_TRUE(world.shared.read()->at(world.frames[0]).features->patches);
  world.add_key_frames(256);
  align_observations(world.shared, world.frames.back());
  EXPECT_FALSE(world.shared.read()->at(world.frames[0]).features->patches);
}

TEST_F(ObservationAlignment, WithoutPatchesEverythingStays) {
  PointScene plain = scene;
  plain.patches = false;
  SceneMap other(plain);
  other.add_key_frames(4);
  const uint64_t revision = other.shared.revision();
  align_observations(other.shared, other.frames.back());
  EXPECT_EQ(other.shared.revision(), revision);
}

}  // namespace
}  // namespace covis
