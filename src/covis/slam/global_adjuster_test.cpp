// SPDX-License-Identifier: Apache-2.0
// The full bundle adjustment beside other work on the map.
#include "covis/slam/global_adjuster.h"

#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/features/test_features.h"

namespace covis {
namespace {

// Cameras along a line looking at random points in front of them, all seen exactly.
struct World {
  static constexpr Pinhole camera{500, 500, 320, 240, 50};
  SharedMap map{camera};
  std::vector<KeyFrameId> frames;
  std::vector<MapPointId> points;
  std::vector<SE3> truth;

  explicit World(int cameras) {
    Random random(1);
    std::vector<Eigen::Vector3d> places;
    for (int p = 0; p < 200; ++p)
      places.emplace_back(random.uniform(-2, 2 + 0.2 * cameras), random.uniform(-2, 2), random.uniform(4, 8));
    for (int c = 0; c < cameras; ++c) {
      truth.emplace_back(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.2 * c, 0, 0));
      add(truth.back(), places);
    }
  }
  void add(const SE3& T_cw, const std::vector<Eigen::Vector3d>& places) {
    auto f = std::make_shared<Features>(no_features());
    for (const Eigen::Vector3d& place : places) {
      const Eigen::Vector3d p_c = T_cw * place;
      const Eigen::Vector2d pixel = camera.project(p_c);
      covis::add(*f, {.x = pixel.x(), .y = pixel.y(), .depth = p_c.z()}, camera.bf);
    }
    finish(*f, {-3000, -3000, 3000, 3000});
    const auto m = map.write();
    const auto count = static_cast<int64_t>(frames.size());
    const KeyFrameId id = m->add_key_frame(count, count, T_cw, f);
    for (uint32_t p = 0; p < places.size(); ++p) {
      if (frames.empty()) {
        points.push_back(m->add_point(places[p], id, p));
      } else {
        m->add_observation(points[p], id, p);
      }
    }
    m->attach_to_tree(id);
    frames.push_back(id);
  }
};

TEST(GlobalAdjuster, TakesItsResultOverBesideNewWork) {
  World world(20);
  Random random(2);
  {  // Bent: every camera but the root is off.
    const auto m = world.map.write();
    for (size_t k = 1; k < world.frames.size(); ++k) {
      Vector6d xi;
      for (int i = 0; i < 6; ++i) xi(i) = random.uniform(-0.02, 0.02);
      m->set_pose(world.frames[k], SE3::exp(xi) * world.truth[k]);
    }
  }
  GlobalAdjuster adjuster;
  EXPECT_FALSE(adjuster.running());
  adjuster.start(world.map, world.frames.front(), 20);
  EXPECT_TRUE(adjuster.running());
  // Meanwhile a key frame goes, and one comes that hangs on the last.
  KeyFrameId fresh;
  SE3 T_fl;  // from the last to it
  {
    const auto m = world.map.write();
    ASSERT_TRUE(m->erase_key_frame(world.frames[7]));
    const KeyFrameId last = world.frames.back();
    T_fl = SE3::exp((Vector6d() << 0.1, 0, 0, 0, 0.05, 0).finished());
    fresh = m->add_key_frame(99, 99, T_fl * m->at(last).T_cw, m->at(last).features);
    m->attach_to_tree(fresh);
    ASSERT_EQ(m->at(fresh).parent, last);
  }
  const uint64_t moves = world.map.read()->moves();
  const GlobalAdjuster::Outcome outcome = adjuster.commit(world.map);
  EXPECT_TRUE(outcome.taken_over);
  EXPECT_FALSE(outcome.focal);
  EXPECT_GT(world.map.read()->moves(), moves) << "what was read of the map before does not fit what is read after";
  EXPECT_FALSE(adjuster.running());
  const auto m = world.map.read();
  EXPECT_EQ(m->check(), "");
  for (size_t k = 0; k < world.frames.size(); ++k) {
    if (k == 7) continue;
    const SE3 off = m->at(world.frames[k]).T_cw * world.truth[k].inverse();
    EXPECT_LT(off.log().norm(), 1e-3) << "key frame " << k;
  }
  const SE3 relative = m->at(fresh).T_cw * m->at(world.frames.back()).T_cw.inverse();
  EXPECT_LT((relative * T_fl.inverse()).log().norm(), 1e-9) << "what came meanwhile keeps its place beside its parent";
}

TEST(GlobalAdjuster, IsGivenUpAtAnyTime) {
  World world(20);
  const SE3 before = world.map.read()->at(world.frames[3]).T_cw;
  for (int k = 0; k < 20; ++k) {
    GlobalAdjuster adjuster;
    adjuster.start(world.map, world.frames.front(), 1000);
    if (k % 2) adjuster.abandon();
    if (k % 4 == 1) adjuster.start(world.map, world.frames.front(), 1000);
  }
  EXPECT_EQ(world.map.read()->at(world.frames[3]).T_cw.t(), before.t());
}

}  // namespace
}  // namespace covis
