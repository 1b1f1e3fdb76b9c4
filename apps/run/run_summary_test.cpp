// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_summary.h"

#include <gtest/gtest.h>

#include "apps/run/test_run.h"

namespace covis::app {
namespace {

RunSummary made_summary(const Trajectory* truth = nullptr) {
  return summarise(made_record(), made_snapshot(), truth, 123);
}

TEST(RunSummary, CountsFrames) {
  RunRecord run = made_record();
  run.frames[9].state = FrameState::unreadable;
  const FrameCounts counts = summarise(run, made_snapshot(), nullptr, 0).frames;
  EXPECT_EQ(counts.all, 10u);
  EXPECT_EQ(counts.tracked, 6u);
  EXPECT_EQ(counts.tracked_online, 5u);
  EXPECT_EQ(counts.first_tracked, 2) << "the first that had a pose at once";
  EXPECT_EQ(counts.late, 1u);
  EXPECT_EQ(counts.unreadable, 1u);
  EXPECT_EQ(summarise({}, {}, nullptr, 0).frames.first_tracked, -1);
}

TEST(RunSummary, CountsWhatAllMapsHold) {
  const MapCounts counts = made_summary().map;
  EXPECT_EQ(counts.key_frames, 3u);
  EXPECT_EQ(counts.points, 42u);
  EXPECT_EQ(counts.submaps.size(), 2u);
}

TEST(RunSummary, TimesAreOfTheFramesThatWereProcessed) {
  const FrameTimes times = made_summary().times;
  // The values are 0, 10 … 90 without the late frame's 70.
  EXPECT_EQ(times.frame.median, 40);
  EXPECT_EQ(times.tracking.median, 38);
  EXPECT_EQ(times.stages.size(), kStages.size());
  for (const auto& [stage, spread] : times.stages)
    EXPECT_EQ(spread.median, stage == std::string("mapping_wait") ? 2 : 0);
}

TEST(RunSummary, CostsAreOfTheWholeRun) {
  const RunCosts costs = made_summary().costs;
  EXPECT_EQ(costs.frames_per_second, 2);
  EXPECT_EQ(costs.peak_rss_mb, 123);
  EXPECT_EQ(costs.first_pose_ms, 12);
}

TEST(RunSummary, LossesAreRunsOfOneState) {
  const std::vector<Loss> losses = made_summary().not_tracked;
  ASSERT_EQ(losses.size(), 3u);
  EXPECT_EQ(losses[0].state, FrameState::not_initialised);
  EXPECT_EQ(losses[1].first, 5);
  EXPECT_EQ(losses[1].last, 6);
  EXPECT_EQ(losses[1].reason, "reason 5") << "the first frame's";
  EXPECT_EQ(losses[2].state, FrameState::late) << "another state is another loss";
  EXPECT_EQ(losses[2].first, losses[2].last);
  RunRecord twice = made_record();
  twice.frames[3].state = FrameState::lost;
  EXPECT_EQ(summarise(twice, made_snapshot(), nullptr, 0).not_tracked.size(), 4u) << "frames between them were tracked";
}

TEST(RunSummary, ALoopHasTheAdjustmentThatFollowedIt) {
  RunRecord run = made_record();
  run.mapping.resize(6);
  for (size_t k = 0; k < run.mapping.size(); ++k) run.mapping[k].frame = static_cast<int64_t>(k);
  run.mapping[1].loop.outcome = LoopOutcome::closed;
  run.mapping[2].full_adjustment_ms = 20;
  run.mapping[3].loop.outcome = LoopOutcome::closed;  // the next loop: no adjustment of its own before the end
  run.mapping[4].loop.outcome = LoopOutcome::joined;
  run.mapping[5].full_adjustment_ms = 7;  // after the maps were joined
  const RunSummary summary = summarise(run, made_snapshot(), nullptr, 0);
  ASSERT_EQ(summary.loops.size(), 2u);
  EXPECT_EQ(summary.loops[0].frame, 1);
  EXPECT_EQ(summary.loops[0].full_ba_ms, 20);
  EXPECT_EQ(summary.loops[1].full_ba_ms, 0);
  ASSERT_EQ(summary.merges.size(), 1u);
  EXPECT_EQ(summary.merges[0].frame, 4);
  EXPECT_EQ(summary.map.key_frames_made, 6u);
}

TEST(RunSummary, AccuracyIsWhereThereIsTruth) {
  EXPECT_FALSE(made_summary().accuracy);
  const Trajectory elsewhere(5);
  EXPECT_FALSE(made_summary(&elsewhere).accuracy) << "too few poses with truth";
  Trajectory truth = main_submap(made_snapshot()).trajectory;
  for (StampedPose& pose : truth) pose.T_wc = SE3(pose.T_wc.R(), 2 * pose.T_wc.t());
  const auto accuracy = made_summary(&truth).accuracy;
  ASSERT_TRUE(accuracy);
  EXPECT_EQ(accuracy->alignment, AlignMode::se3);
  EXPECT_GT(accuracy->ate, 0.5) << "without scale";
  ASSERT_TRUE(accuracy->scaled);
  EXPECT_NEAR(accuracy->scaled->scale, 2, 1e-9);
  EXPECT_NEAR(accuracy->scaled->ate, 0, 1e-9);
  RunRecord mono = made_record();
  mono.sensor = Sensor::monocular;
  EXPECT_EQ(summarise(mono, made_snapshot(), &truth, 0).accuracy->alignment, AlignMode::sim3);
}

}  // namespace
}  // namespace covis::app
