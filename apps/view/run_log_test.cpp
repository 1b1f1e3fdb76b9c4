// SPDX-License-Identifier: Apache-2.0
#include "apps/view/run_log.h"

#include <gmock/gmock.h>

namespace covis::view {
namespace {

using testing::ElementsAre;

TEST(RunLog, KeepsEachReasonOnce) {
  RunLog log;
  for (const char* reason : {"", "dark", "", "blurred", "dark"}) log.add(FrameRow(), reason);
  EXPECT_THAT(log.texts(), ElementsAre("", "dark", "blurred"));
  EXPECT_EQ(log.frames()[0].reason, 0);
  EXPECT_EQ(log.frames()[3].reason, 2);
  EXPECT_EQ(log.frames()[4].reason, 1);
}

TEST(RunLog, BeyondItsLimitOfReasonsItKeepsTheFirst) {
  RunLog log;
  for (int k = 0; k < 70000; ++k) log.add(FrameRow(), "reason " + std::to_string(k));
  EXPECT_EQ(log.texts().size(), 65536u);
  EXPECT_EQ(log.frames()[65534].reason, 65535);
  EXPECT_EQ(log.frames().back().reason, 0);
}

TEST(RunLog, CountsHowOftenALoopChanged) {
  RunLog log;
  LoopPaths loop;
  loop.after = {{1, {0, 0, 0}}};
  log.set_loops({loop});
  log.set_loops({loop, LoopPaths()});
  EXPECT_THAT(log.loop_versions(), ElementsAre(1, 1));
  loop.after.front().position[0] = 5;
  log.set_loops({loop, LoopPaths()});
  EXPECT_THAT(log.loop_versions(), ElementsAre(2, 1));
}

}  // namespace
}  // namespace covis::view
