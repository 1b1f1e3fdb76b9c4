// SPDX-License-Identifier: Apache-2.0
// A case for each criterion: a candidate that is accepted, and the same with one thing changed.
#include "covis/loops/loop_verifier.h"

#include <gtest/gtest.h>

#include <numbers>

#include "covis/loops/test_loop_scene.h"

namespace covis {
namespace {

class LoopVerifierTest : public testing::Test {
 protected:
  void SetUp() override { around.go_around(); }

  LoopCandidate candidate() const { return {*around.world.shared.read(), around.current, around.place()}; }
  static LoopVerdict verify(const LoopCandidate& candidate, const LoopOptions& options = {},
                            Sensor sensor = Sensor::rgbd) {
    return LoopVerifier(sensor, options, 0).verify(candidate);
  }
  static LoopRefusal refusal(const LoopCandidate& candidate, const LoopOptions& options = {}) {
    const LoopVerdict verdict = verify(candidate, options);
    EXPECT_EQ(verdict.loop.has_value(), verdict.refusal == LoopRefusal::none);
    return verdict.refusal;
  }

  // As many points of the place again, which are not there.
  static LoopCandidate with_twice_the_points(LoopCandidate crowded) {
    PointSet& points = crowded.place.points;
    const size_t there = points.size();
    Random random(1);
    for (size_t k = 0; k < there; ++k) {
      points.id.push_back({static_cast<uint32_t>(100000 + k), 0});
      for (auto* array : {&points.px, &points.py, &points.pz}) array->push_back(double{(*array)[k]});
      for (auto* array : {&points.nx, &points.ny, &points.nz, &points.d_min, &points.d_max})
        array->push_back(float{(*array)[k]});
      points.descriptor.push_back(random_descriptor(random));
    }
    return crowded;
  }

  LoopScene around;
};

class JoinVerifierTest : public LoopVerifierTest {
 protected:
  // The second submap has its world elsewhere.
  const SE3 shift = SE3::exp((Vector6d() << 3, 1, -2, 0.1, 0.7, 0.2).finished());
  void SetUp() override { around.go_twice(12, shift); }

  LoopCandidate candidate() const { return {*around.world.shared.read(), around.current, around.world.frames[11]}; }
};

TEST_F(LoopVerifierTest, ThePlaceSeenAgainIsALoop) {
  const LoopVerdict verdict = verify(candidate());
  ASSERT_EQ(verdict.refusal, LoopRefusal::none);
  ASSERT_TRUE(verdict.loop);
  EXPECT_EQ(verdict.loop->relation, LoopRelation::same_submap);
  EXPECT_GE(verdict.evidence.matches, 20);
  EXPECT_GE(verdict.evidence.inliers, 20);
  EXPECT_EQ(verdict.evidence.found_again, static_cast<int>(verdict.loop->matches.size()));
  const SE3 truth = around.scene.T_cw(around.world.frames.size() - 1);
  EXPECT_LT((verdict.loop->S_cw.as_pose() * truth.inverse()).log().norm(), 0.02) << "where the old place has it";
  ASSERT_TRUE(verdict.drift);
  EXPECT_NEAR(verdict.drift->path, 2 * std::numbers::pi * 2, 1);
  EXPECT_GT(verdict.drift->past, verdict.drift->path);
  EXPECT_EQ(verdict.drift->scale, 1) << "known, with depth";
}

TEST_F(LoopVerifierTest, FewMatches) {
  LoopCandidate few = candidate();
  few.members.clear();
  EXPECT_EQ(refusal(few), LoopRefusal::few_matches);
}

TEST_F(LoopVerifierTest, NoSimilarity) {
  LoopCandidate shuffled = candidate();
  std::rotate(shuffled.current.positions.begin(), shuffled.current.positions.begin() + 7,
              shuffled.current.positions.end());
  EXPECT_EQ(refusal(shuffled), LoopRefusal::no_similarity);
}

TEST_F(LoopVerifierTest, NotFoundAgain) {
  EXPECT_EQ(refusal(candidate(), {.min_found = 5000}), LoopRefusal::not_found_again);
}

TEST_F(LoopVerifierTest, SmallShareOfThoseInView) {
  const LoopCandidate crowded = with_twice_the_points(candidate());
  EXPECT_EQ(refusal(crowded, {.min_found_share = 0.7}), LoopRefusal::small_share);
  EXPECT_EQ(refusal(candidate(), {.min_found_share = 0.7}), LoopRefusal::none);
}

TEST_F(LoopVerifierTest, TiedAlready) {
  LoopCandidate tied = candidate();
  const LoopVerdict open = verify(tied);
  ASSERT_TRUE(open.loop);
  const auto& matches = open.loop->matches;
  for (size_t k = 0; k < matches.size() * 6 / 10; ++k) tied.current.points[matches[k].first] = matches[k].second;
  EXPECT_EQ(refusal(tied), LoopRefusal::tied_already);
}

TEST_F(LoopVerifierTest, NeighboursDisagree) {
  LoopCandidate alone = candidate();
  ASSERT_GE(alone.neighbours.size(), 2u);
  for (KeyFrameView& neighbour : alone.neighbours)
    neighbour.features = std::make_shared<Features>([] {
      Features none = no_features();
      finish(none);
      return none;
    }());
  EXPECT_EQ(refusal(alone), LoopRefusal::neighbours_disagree);
  EXPECT_TRUE(verify(alone).claim) << "another key frame may say the same";
  alone.neighbours.clear();
  EXPECT_EQ(refusal(alone), LoopRefusal::none) << "there is none to be asked";
}

TEST_F(LoopVerifierTest, DriftTooGreat) {
  LoopCandidate near = candidate();
  near.travel = {.length = 0.5};
  EXPECT_EQ(refusal(near), LoopRefusal::drift_too_great) << "so short a way makes no such drift";
  EXPECT_EQ(refusal(candidate(), {.max_rotation = 0.1}), LoopRefusal::drift_too_great);
  const LoopVerdict verdict = verify(near);
  ASSERT_TRUE(verdict.drift);
  EXPECT_GT(verdict.drift->distance, 0.1);
}

// A camera that turns on the spot drifts as well: what it sees moves past it.
TEST_F(LoopVerifierTest, TurnsMakeDriftAsPathsDo) {
  LoopCandidate turned = candidate();
  turned.travel = {.length = 0.5, .turned = 2 * std::numbers::pi};
  EXPECT_EQ(refusal(turned), LoopRefusal::none);
  const LoopVerdict verdict = verify(turned);
  ASSERT_TRUE(verdict.drift);
  EXPECT_EQ(verdict.drift->path, 0.5);
  EXPECT_NEAR(verdict.drift->past, 0.5 + 2 * std::numbers::pi * median_depth(*verdict.loop), 1e-9);
  turned.neighbours.clear();
  EXPECT_EQ(verify(turned, {.max_drift_mono = 0.1}, Sensor::monocular).refusal, LoopRefusal::drift_too_great)
      << "one camera: by the path alone";
}

TEST_F(LoopVerifierTest, TheWayAroundTheRingHasItsLengthAndOneTurn) {
  EXPECT_NEAR(candidate().travel.turned, 2 * std::numbers::pi * (LoopScene::kSteps + 3) / LoopScene::kSteps, 0.7);
}

// A loop that no drift explains is a claim only with as much evidence as joining submaps needs.
TEST_F(LoopVerifierTest, WithoutEnoughEvidenceAGreatDriftIsNoClaim) {
  LoopCandidate near = candidate();
  near.travel = {.length = 0.5};
  EXPECT_TRUE(verify(near).claim);
  EXPECT_FALSE(verify(candidate()).claim) << "it is a loop";
  const int found = verify(near).evidence.found_again;
  EXPECT_FALSE(verify(near, {.merge_min_found = found + 1}).claim);
  EXPECT_FALSE(verify(with_twice_the_points(near), {.merge_min_found_share = 0.7}).claim);
  Random random(1);
  for (Descriptor& descriptor : near.here.points.descriptor) descriptor = random_descriptor(random);
  const LoopVerdict onesided = verify(near);
  EXPECT_EQ(onesided.refusal, LoopRefusal::drift_too_great);
  EXPECT_FALSE(onesided.claim) << "not seen from there";
}

TEST_F(LoopVerifierTest, AScaleThatChangedIsFoundWithoutDepth) {
  LoopScene mono(Sensor::monocular);
  mono.drift.setZero();
  mono.go_around();
  // From the place's very centre every scale would do: another key frame of it.
  LoopCandidate larger(*mono.world.shared.read(), mono.current, mono.world.frames[1]);
  // The world around the current key frame, grown by a tenth about its camera.
  constexpr double kGrowth = 1.1;
  const Eigen::Vector3d centre = larger.current.T_cw.centre();
  for (Eigen::Vector3d& position : larger.current.positions) position = centre + kGrowth * (position - centre);
  PointSet& here = larger.here.points;
  for (size_t k = 0; k < here.size(); ++k) {
    const Eigen::Vector3d moved = centre + kGrowth * (here.position(k) - centre);
    here.px[k] = moved.x(), here.py[k] = moved.y(), here.pz[k] = moved.z();
  }
  for (KeyFrameView& neighbour : larger.neighbours) {
    const Eigen::Vector3d moved = centre + kGrowth * (neighbour.T_cw.centre() - centre);
    neighbour.T_cw = SE3(neighbour.T_cw.R(), Eigen::Vector3d(-(neighbour.T_cw.R() * moved)));
  }
  const LoopVerdict verdict = verify(larger, {}, Sensor::monocular);
  ASSERT_TRUE(verdict.drift);
  EXPECT_NEAR(verdict.drift->scale, kGrowth, 0.02);
  EXPECT_EQ(verdict.refusal, LoopRefusal::none);
  EXPECT_EQ(verify(larger, {.max_scale = 1.05}, Sensor::monocular).refusal, LoopRefusal::drift_too_great);
}

TEST_F(LoopVerifierTest, TheViewsAroundSayMoreThanTheCurrentOne) {
  LoopScene mono(Sensor::monocular);
  mono.drift.setZero();
  mono.go_around();
  LoopCandidate candidate(*mono.world.shared.read(), mono.current, mono.world.frames[1]);
  ASSERT_GE(candidate.neighbours.size(), 3u);
  // The current image alone is off by a pixel and a half, as if the camera had turned by three thousandths.
  Features shifted = *candidate.current.features;
  for (float& x : shifted.x) x += 1.5f;
  finish(shifted, mono.scene.bounds);
  candidate.current.features = std::make_shared<const Features>(std::move(shifted));
  const LoopVerdict verdict = verify(candidate, {}, Sensor::monocular);
  ASSERT_TRUE(verdict.loop);
  const SE3 truth = mono.scene.T_cw(mono.world.frames.size() - 1);
  EXPECT_LT(so3_log(verdict.loop->S_cw.as_pose().R() * truth.R().transpose()).norm(), 0.001);
  EXPECT_NEAR(verdict.loop->S_cw.scale(), 1, 0.003);
}

// A strip of the place, seen by one view, says less than the whole of it.
TEST_F(LoopVerifierTest, AStripOfThePlaceCorrectsLess) {
  const LoopCandidate whole = candidate();
  LoopCandidate strip = whole;
  strip.neighbours.clear();
  strip.members.resize(1);
  PointSet& points = strip.place.points;
  Random random(1);
  for (size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d p = whole.place.T_cw * points.position(k);
    if (std::abs(p.x() / p.z()) > 0.06) points.descriptor[k] = random_descriptor(random);
  }
  const LoopOptions little{.min_matches = 10, .min_inliers = 10, .min_found = 10, .min_found_share = 0};
  LoopVerdict all = verify(whole, little), some = verify(strip, little);
  ASSERT_TRUE(all.loop);
  ASSERT_TRUE(some.loop);
  const LoopDrift known = *all.drift, open = *some.drift;
  all.drift = weigh_against_drift(whole, Sensor::rgbd, *all.loop);
  some.drift = weigh_against_drift(strip, Sensor::rgbd, *some.loop);
  const double share = all.drift->distance / known.distance, of_strip = some.drift->distance / open.distance;
  EXPECT_GT(share, 0.9);
  EXPECT_LT(share, 1);
  EXPECT_LT(of_strip, 0.9);
  EXPECT_GT(of_strip, 0.5) << "so great a drift is believed for the most part";
}

TEST_F(LoopVerifierTest, NothingToCorrectWhereNothingDrifted) {
  LoopScene exact;
  exact.drift.setZero();
  exact.go_around();
  const LoopCandidate back(*exact.world.shared.read(), exact.current, exact.place());
  const LoopVerdict verdict = verify(back);
  ASSERT_TRUE(verdict.loop);
  EXPECT_TRUE(nothing_to_correct(*verdict.loop, back.camera));
  const LoopVerdict drifted = verify(candidate());
  EXPECT_FALSE(nothing_to_correct(*drifted.loop, back.camera));
}

TEST_F(JoinVerifierTest, ThePlaceInAnotherSubmapJoinsThem) {
  const LoopVerdict verdict = verify(candidate());
  ASSERT_EQ(verdict.refusal, LoopRefusal::none);
  EXPECT_EQ(verdict.loop->relation, LoopRelation::other_submap);
  EXPECT_LT((verdict.loop->S_cw.as_pose() * around.scene.T_wc_of(11)).log().norm(), 0.02);
}

TEST_F(JoinVerifierTest, NoDriftIsExpectedBetweenTwoSubmaps) {
  LoopVerdict verdict = verify(candidate());
  ASSERT_TRUE(verdict.loop);
  const Sim3 found = verdict.loop->S_cw;
  verdict.loop->information = Matrix7d::Zero();
  weigh_against_drift(candidate(), Sensor::rgbd, *verdict.loop);
  EXPECT_EQ((verdict.loop->S_cw.R() - found.R()).norm() + (verdict.loop->S_cw.t() - found.t()).norm(), 0);
}

TEST_F(JoinVerifierTest, MoreMustBeFoundAgain) {
  const int found = verify(candidate()).evidence.found_again;
  EXPECT_EQ(refusal(candidate(), {.merge_min_found = found + 1}), LoopRefusal::not_found_again);
  EXPECT_EQ(refusal(candidate(), {.min_found = found + 1}), LoopRefusal::none) << "that is for loops";
  EXPECT_EQ(refusal(with_twice_the_points(candidate()), {.merge_min_found_share = 0.7}), LoopRefusal::small_share);
}

TEST_F(JoinVerifierTest, ANeighbourMustAgree) {
  LoopCandidate alone = candidate();
  alone.neighbours.clear();
  EXPECT_EQ(refusal(alone), LoopRefusal::neighbours_disagree) << "with none there is none that agrees";
}

TEST_F(JoinVerifierTest, NotSeenFromThere) {
  LoopCandidate onesided = candidate();
  Random random(1);
  for (Descriptor& descriptor : onesided.here.points.descriptor) descriptor = random_descriptor(random);
  EXPECT_EQ(refusal(onesided), LoopRefusal::not_seen_from_there);
}

}  // namespace
}  // namespace covis
