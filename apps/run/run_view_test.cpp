// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_view.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/run/test_run.h"

namespace covis::app {
namespace {

using testing::ElementsAre;

TEST(RunView, EveryFrameIsThereWithItsStateAndReason) {
  const RunRecord run = made_record();
  const Snapshot snapshot = made_snapshot();
  const view::ViewState state = view_state(run, snapshot, summarise(run, snapshot, nullptr, 1), "ten");
  ASSERT_EQ(state.log.frames().size(), 10u);
  const view::FrameRow &tracked = state.log.frames()[2], &lost = state.log.frames()[5], &late = state.log.frames()[7];
  EXPECT_TRUE(tracked.flags & view::FrameRow::kHasPose);
  EXPECT_FLOAT_EQ(tracked.pose.t[0], 2);
  EXPECT_FLOAT_EQ(tracked.tracking_ms, 18);
  EXPECT_EQ(tracked.reason, 0);
  EXPECT_FALSE(lost.flags & view::FrameRow::kHasPose);
  EXPECT_EQ(state.log.texts()[lost.reason], "reason 5");
  EXPECT_EQ(late.inliers, 0);
  EXPECT_EQ(state.map->path.size(), snapshot.trajectory.size());
}

TEST(RunView, TheInfoNamesTheStatesInTheOrderOfTheirNumbers) {
  RunRecord run = made_record();
  run.image_width = 640;
  const nlohmann::json info = view_info(run, "ten", "live");
  EXPECT_EQ(info["title"], "ten");
  EXPECT_EQ(info["mode"], "live");
  EXPECT_EQ(info["camera"]["width"], 640);
  EXPECT_EQ(info["states"][static_cast<size_t>(FrameState::late)], "late");
  EXPECT_EQ(info["states"][static_cast<size_t>(FrameState::unreadable)], "unreadable");
}

}  // namespace
}  // namespace covis::app
