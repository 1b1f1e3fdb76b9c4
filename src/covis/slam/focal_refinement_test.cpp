// SPDX-License-Identifier: Apache-2.0
// The focal length adjusted beside other work on a monocular map.
#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/slam/global_adjuster.h"

namespace covis {
namespace {

// Sixteen views of a camera of focal length 500 that drives forward and turns, said to have `claimed` times that.
void drive(SharedMap& shared, double claimed) {
  const Pinhole truth{500, 500, 320, 240, 0};
  Random random(3);
  std::vector<SE3> T_wc;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int k = 0; k < 16; ++k) {
    const SE3 rotation = SE3::exp((Vector6d() << 0, 0, 0, 0, 0.05 * k, 0).finished());
    T_wc.emplace_back(rotation.R(), centre);
    centre += rotation.R() * Eigen::Vector3d(0, 0, 0.5);
  }
  std::vector<Eigen::Vector3d> places;
  for (size_t p = 0; p < 800; ++p)
    places.push_back(T_wc[p % 16] *
                     Eigen::Vector3d(random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(4, 14)));
  const auto map = shared.write();
  const auto pyramid = std::make_shared<ScalePyramid>(8, 1.2f);
  std::vector<MapPointId> points(places.size());
  for (const SE3& pose : T_wc) {
    const SE3 T_cw = pose.inverse();
    auto f = std::make_shared<Features>();
    f->pyramid = pyramid;
    f->camera = {500 * claimed, 500 * claimed, 320, 240, 0};
    std::vector<size_t> seen;
    for (size_t p = 0; p < places.size(); ++p) {
      const Eigen::Vector3d p_c = T_cw * places[p];
      if (p_c.z() < 1) continue;
      const Eigen::Vector2d pixel = truth.project(p_c);
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() >= 640 || pixel.y() >= 480) continue;
      f->x.push_back(static_cast<float>(pixel.x() + random.uniform(-0.5, 0.5)));
      f->y.push_back(static_cast<float>(pixel.y() + random.uniform(-0.5, 0.5)));
      f->angle.push_back(0);
      f->u_right.push_back(-1);
      f->depth.push_back(0);
      f->level.push_back(0);
      f->descriptor.push_back({});
      seen.push_back(p);
    }
    f->grid.build({0, 0, 640, 480}, f->x, f->y);
    const auto serial = static_cast<int64_t>(map->next_serial());
    const KeyFrameId id = map->add_key_frame(serial, serial, T_cw, f);
    for (uint32_t i = 0; i < seen.size(); ++i) {
      MapPointId& point = points[seen[i]];
      if (point.valid()) {
        map->add_observation(point, id, i);
      } else {
        point = map->add_point(places[seen[i]], id, i);
      }
    }
    map->attach_to_tree(id);
  }
}

TEST(FocalRefinement, GivesTheMapTheCameraItTells) {
  SharedMap map;
  drive(map, 1.02);
  GlobalAdjuster adjuster;
  adjuster.start_focal(map, map.read()->root(), 510);
  ASSERT_TRUE(adjuster.running());
  EXPECT_TRUE(adjuster.refines_focal());
  adjuster.commit(map);
  ASSERT_TRUE(adjuster.refined_camera());
  EXPECT_NEAR(adjuster.refined_camera()->fx, 500, 2.5);
  const auto m = map.read();
  EXPECT_EQ(m->check(), "");
  for (const KeyFrameId& id : m->key_frames()) EXPECT_EQ(m->at(id).features->camera.fx, adjuster.refined_camera()->fx);
}

TEST(FocalRefinement, LeavesARightOneAndTheMap) {
  SharedMap map;
  drive(map, 1.0);
  std::vector<SE3> before;
  for (const KeyFrameId& id : map.read()->key_frames()) before.push_back(map.read()->at(id).T_cw);
  GlobalAdjuster adjuster;
  adjuster.start_focal(map, map.read()->root(), 500);
  adjuster.commit(map);
  EXPECT_FALSE(adjuster.refined_camera());
  const auto m = map.read();
  size_t k = 0;
  for (const KeyFrameId& id : m->key_frames()) {
    EXPECT_EQ(m->at(id).features->camera.fx, 500);
    EXPECT_EQ(m->at(id).T_cw.t(), before[k++].t());
  }
}

TEST(FocalRefinement, KeepsNearTheGivenOne) {
  SharedMap map;
  drive(map, 1.02);
  GlobalAdjuster adjuster;
  adjuster.start_focal(map, map.read()->root(), 530);  // what the map tells is more than 5 % away from this
  adjuster.commit(map);
  EXPECT_FALSE(adjuster.refined_camera());
}

}  // namespace
}  // namespace covis
