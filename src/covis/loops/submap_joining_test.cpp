// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/submap_joining.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "covis/loops/join_plan.h"
#include "covis/loops/test_loop_scene.h"
#include "covis/map/map_state.h"

namespace covis {
namespace {

const SE3 kShift = SE3::exp((Vector6d() << 3, 1, -2, 0.1, 0.7, 0.2).finished());

// Submaps of a scene, each along some steps of its path, in a world of its own.
struct Pieces {
  PointScene scene;
  SceneMap world;
  Sensor sensor;

  explicit Pieces(PointScene of, Sensor by = Sensor::rgbd) : scene(std::move(of)), world(scene, by), sensor(by) {}

  // A submap of the steps from `first` to before `last`, displaced by T_shift, with a drift that grows to `drift`.
  void add(size_t first, size_t last, const SE3& T_shift = SE3(), const Vector6d& drift = Vector6d::Zero()) {
    world.begin_submap();
    for (size_t i = first; i < last; ++i) {
      const Vector6d xi = drift * (static_cast<double>(i - first) / static_cast<double>(last - first));
      world.add(scene.T_cw(i), SE3::exp(xi) * scene.T_cw(i) * T_shift);
      steps.push_back(i);
    }
  }
  // Lengths of a submap become `factor` times as great.
  void scale(uint32_t submap, double factor) {
    const auto map = world.shared.write();
    for (const KeyFrameId& id : map->key_frames(submap)) {
      const SE3& T = map->at(id).T_cw;
      map->set_pose(id, SE3(T.R(), Eigen::Vector3d(factor * T.t())));
    }
    for (const MapPointId& id : map->points()) {
      if (map->at(map->at(id).reference).submap != submap) continue;
      map->set_position(id, factor * map->at(id).position_w);
      map->refresh_point(id);
    }
  }
  JoinReport join() {
    const JoinReport report = join_submaps(world.shared, {.sensor = sensor, .loop = {}, .mapper = {}, .seed = 0});
    EXPECT_EQ(world.shared.read()->check(), "");
    return report;
  }
  // The greatest distance of a key frame of the oldest submap from its true place.
  double worst() const {
    const auto map = world.shared.read();
    double greatest = 0;
    for (size_t k = 0; k < world.frames.size(); ++k) {
      const KeyFrame& key_frame = map->at(world.frames[k]);
      if (key_frame.submap != 0) continue;
      greatest = std::max(greatest, (key_frame.T_cw.centre() - scene.T_wc_of(steps[k]).t()).norm());
    }
    return greatest;
  }
  size_t submaps() const { return world.shared.read()->submaps().size(); }

  std::vector<size_t> steps;  // one step of the scene's path for each key frame
};

class JoinedPieces : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, JoinedPieces, testing::Values(Sensor::rgbd, Sensor::monocular),
                         [](const auto& instance) { return std::string(name(instance.param)); });

TEST_P(JoinedPieces, AreOneMapInTheOldestWorld) {
  const bool monocular = GetParam() == Sensor::monocular;
  Pieces pieces(PointScene::ring(2400, LoopScene::kSteps), GetParam());
  pieces.add(0, 16);
  pieces.add(8, 24, kShift);
  pieces.add(20, 36, kShift.inverse());
  if (monocular) pieces.scale(1, 1.7);
  const size_t points = pieces.world.shared.read()->point_count();
  const JoinReport report = pieces.join();
  EXPECT_EQ(pieces.submaps(), 1u);
  EXPECT_LT(pieces.worst(), 0.02);
  ASSERT_EQ(report.maps.size(), 1u);
  EXPECT_EQ(report.maps[0].of, (std::vector<uint32_t>{0, 1, 2}));
  ASSERT_EQ(report.pairs.size(), 3u);
  const JoinedPair& first = report.pairs[0];
  EXPECT_EQ(first.refusal, JoinRefusal::none);
  EXPECT_GE(first.claims, 8);
  EXPECT_EQ(first.contrary, 0);
  EXPECT_GT(first.views_agree, 4);
  EXPECT_EQ(first.views_disagree, 0);
  EXPECT_GT(first.fused, 500);
  EXPECT_NEAR(first.S_older_younger.scale(), monocular ? 1 / 1.7 : 1, 1e-3);
  EXPECT_NE(report.pairs[1].refusal, JoinRefusal::none) << "the first and the last see hardly anything of each other";
  EXPECT_LT(pieces.world.shared.read()->point_count(), 0.75 * static_cast<double>(points)) << "duplicates are fused";
}

// One camera's lengths become metres, whichever of both maps is older.
TEST(SubmapJoining, ACameraWithoutDepthLearnsMetres) {
  for (const bool older : {false, true}) {
    Pieces pieces(PointScene::ring(1600, LoopScene::kSteps));
    for (const bool without_depth : {older, !older}) {
      pieces.world.sensor = without_depth ? Sensor::monocular : Sensor::rgbd;
      without_depth ? pieces.add(0, 12, kShift) : pieces.add(4, 16);
    }
    pieces.scale(older ? 0 : 1, 1.7);
    const JoinReport report = pieces.join();
    ASSERT_EQ(pieces.submaps(), 1u);
    EXPECT_EQ(report.maps[0].id, older ? 1u : 0u) << "the one with depth keeps its world";
    EXPECT_NEAR(report.pairs[0].S_older_younger.scale(), older ? 1.7 : 1 / 1.7, 1e-2);
    const auto map = pieces.world.shared.read();
    for (size_t k = 0; k < pieces.world.frames.size(); ++k) {
      const Eigen::Vector3d centre = map->at(pieces.world.frames[k]).T_cw.centre();
      EXPECT_LT((centre - pieces.scene.T_wc_of(pieces.steps[k]).t()).norm(), 0.02) << k;
    }
  }
}

TEST(SubmapJoining, TheDriftBetweenTwoSeamsIsSpread) {
  Pieces pieces(PointScene::ring(2400, LoopScene::kSteps));
  pieces.add(0, 14);
  // Around the rest of the ring and over its beginning: both ends see the first piece.
  pieces.add(10, LoopScene::kSteps + 6, kShift, (Vector6d() << 0.15, 0.08, 0.05, 0, 0.03, 0).finished());
  const JoinReport report = pieces.join();
  ASSERT_EQ(pieces.submaps(), 1u);
  EXPECT_EQ(report.pairs[0].contrary, 0);
  EXPECT_GT(report.maps[0].correction, 0.05);
  EXPECT_LT(pieces.worst(), 0.03);
}

TEST(SubmapJoining, WhatSharesNothingStaysApart) {
  Pieces pieces(PointScene::ring(2400, LoopScene::kSteps));
  pieces.add(0, 8);
  pieces.add(24, 32, kShift);
  const auto before = pieces.world.shared.read()->state();
  const JoinReport report = pieces.join();
  EXPECT_EQ(pieces.submaps(), 2u);
  EXPECT_EQ(report.pairs[0].refusal, JoinRefusal::not_alike);
  EXPECT_EQ(report.maps.size(), 2u);
  const auto after = pieces.world.shared.read()->state();
  for (size_t k = 0; k < before.key_frames.size(); ++k)
    EXPECT_EQ(before.key_frames[k].T_cw.t(), after.key_frames[k].T_cw.t());
}

// One submap has two places that look like the other's: nobody can tell which of them it is.
TEST(SubmapJoining, APlaceThatIsThereTwiceJoinsNothing) {
  Pieces pieces(PointScene::twin_halves(2400, LoopScene::kSteps));
  pieces.add(0, LoopScene::kSteps);
  pieces.add(6, 18, kShift);
  const JoinReport report = pieces.join();
  EXPECT_EQ(pieces.submaps(), 2u);
  EXPECT_EQ(report.pairs[0].refusal, JoinRefusal::ambiguous);
  EXPECT_GT(report.pairs[0].contrary, 2);
}

// … and a place that is known to be there twice is not believed about a third submap either, which has it once.
TEST(SubmapJoining, AnUnsurePlaceIsUnsureEverywhere) {
  Pieces pieces(PointScene::twin_halves(2400, LoopScene::kSteps));
  pieces.add(0, LoopScene::kSteps);
  pieces.add(6, 18, kShift);
  pieces.add(30, 42, kShift.inverse());  // the other half, which looks the same as the second submap
  const JoinReport report = pieces.join();
  EXPECT_EQ(pieces.submaps(), 3u);
  for (const JoinedPair& pair : report.pairs) EXPECT_EQ(pair.refusal, JoinRefusal::ambiguous);
}

// Two places that are equal over a stretch of the way, and go on as others: each submap has one of them.
TEST(SubmapJoining, WhatDiffersBehindTheDoorsIsNotJoined) {
  PointScene scene = PointScene::twin_halves(2400, LoopScene::kSteps);
  Random random(7);
  for (PointScene::Point& point : scene.points) {
    if (!point.twin_of || point.position_w.z() > 1) continue;
    point.descriptor = random_descriptor(random);
    point.twin_of.reset();
  }
  Pieces pieces(std::move(scene));
  pieces.add(0, 20);
  pieces.add(24, 44, kShift);
  {
    const auto map = pieces.world.shared.write();
    for (const MapPointId& id : map->points()) {
      map->count_visible(id, 9);
      map->count_found(id, 9);
    }
  }
  const JoinReport report = pieces.join();
  EXPECT_EQ(pieces.submaps(), 2u);
  const JoinedPair& pair = report.pairs[0];
  EXPECT_EQ(pair.refusal, JoinRefusal::contradicted);
  EXPECT_GE(pair.claims, 5);
  EXPECT_GE(pair.views_agree, pair.views_disagree) << "most of what stands side by side sees the same";
  EXPECT_GT(pair.views_contradict, 0);
}

TEST(SubmapJoining, TwoViewsAreNotBelieved) {
  Pieces pieces(PointScene::ring(2400, LoopScene::kSteps));
  pieces.add(0, 16);
  pieces.add(8, 24, kShift);
  const auto map = pieces.world.shared.read();
  JoinClaims found = JoinClaims::collect(*map, Sensor::rgbd, {}, 0);
  ASSERT_GE(found.claims.size(), 8u);
  LoopVerifier verifier(Sensor::rgbd, {}, 0);
  EXPECT_EQ(JoinPlan(*map, found, verifier).groups.size(), 1u);
  // Two claims, each of another pair of key frames, that agree.
  const auto other = std::find_if(found.claims.begin() + 1, found.claims.end(), [&](const JoinClaim& claim) {
    return claim.current != found.claims[0].current && claim.current != found.claims[0].place;
  });
  ASSERT_NE(other, found.claims.end());
  found.claims = {found.claims[0], *other};
  const JoinPlan plan(*map, found, verifier);
  EXPECT_TRUE(plan.groups.empty());
  EXPECT_EQ(plan.pairs[0].claims, 2);
  EXPECT_EQ(plan.pairs[0].contrary, 0);
  EXPECT_EQ(plan.pairs[0].refusal, JoinRefusal::unconfirmed);
}

// Two walks through the same: every key frame sees what one of the other walk sees, and says so to its neighbours too.
TEST(SubmapJoining, ClaimsBetweenTheSameSurroundingsAreMadeAFewTimes) {
  Pieces pieces(PointScene::ring(2400, 4 * LoopScene::kSteps));
  pieces.add(0, 60);
  pieces.add(0, 60, kShift);
  const auto map = pieces.world.shared.read();
  const JoinClaims found = JoinClaims::collect(*map, Sensor::rgbd, {}, 0);
  EXPECT_GE(found.claims.size(), 20u);
  EXPECT_LE(found.claims.size(), 80u) << "of 120 key frames that see the other walk's";
  // … and yet all along the way.
  const auto claimed_near = [&](size_t step) {
    return std::any_of(found.claims.begin(), found.claims.end(), [&](const JoinClaim& claim) {
      const KeyFrameId there = pieces.world.frames[step];
      return claim.current == there || claim.place == there || map->weight(claim.current, there) > 0 ||
             map->weight(claim.place, there) > 0;
    });
  };
  for (size_t step = 0; step < 60; ++step) EXPECT_TRUE(claimed_near(step)) << step;
}

// A map of a moment has seen nothing by which two equal rooms would differ.
TEST(SubmapJoining, AMapOfFourKeyFramesIsNotBelieved) {
  for (const size_t count : {4, 5}) {
    Pieces pieces(PointScene::ring(2400, LoopScene::kSteps));
    pieces.add(0, 16);
    pieces.add(4, 4 + count, kShift);
    const JoinReport report = pieces.join();
    EXPECT_GE(report.pairs[0].claims, 3);
    EXPECT_EQ(report.pairs[0].refusal, count < 5 ? JoinRefusal::too_small : JoinRefusal::none);
  }
}

// Five claims outweigh two; three do not, once a third submap makes key frames of the others unsure.
TEST(SubmapJoining, ClaimsAreCountedAgainWithoutUnsureOnes) {
  Pieces pieces(PointScene::ring(2400, LoopScene::kSteps));
  for (int k = 0; k < 3; ++k) pieces.add(0, 12);
  const auto map = pieces.world.shared.read();
  const auto& frames = pieces.world.frames;
  JoinClaims found;
  const auto claim = [&](size_t current, size_t place, const SE3& S_there_here) {
    Loop loop;
    loop.place = LoopPlace(*map, frames[place]);
    loop.S_cw = Sim3(map->at(frames[current]).T_cw * S_there_here.inverse());
    for (size_t k = 0; k < 20; ++k) loop.matches.emplace_back(0, loop.place.points.id[k]);
    found.claims.emplace_back(*map, frames[current], loop, LoopEvidence());
  };
  const SE3 right, wrong(Eigen::Matrix3d::Identity(), Eigen::Vector3d(40, 0, 0));
  for (size_t k = 0; k < 5; ++k) claim(12 + k, k, right);
  for (size_t k = 5; k < 7; ++k) claim(12 + k, k, wrong);
  LoopVerifier verifier(Sensor::rgbd, {}, 0);
  const JoinPlan before(*map, found, verifier);
  EXPECT_EQ(before.groups.size(), 1u);
  EXPECT_EQ(before.pairs[0].claims, 5);
  EXPECT_EQ(before.pairs[0].contrary, 2);
  claim(24, 0, right);
  claim(25, 1, wrong);
  const JoinPlan plan(*map, found, verifier);
  EXPECT_EQ(plan.pairs[1].refusal, JoinRefusal::ambiguous);
  EXPECT_EQ(plan.pairs[0].claims, 3);
  EXPECT_EQ(plan.pairs[0].contrary, 2);
  EXPECT_EQ(plan.pairs[0].refusal, JoinRefusal::ambiguous);
  EXPECT_TRUE(plan.groups.empty());
}

}  // namespace
}  // namespace covis
