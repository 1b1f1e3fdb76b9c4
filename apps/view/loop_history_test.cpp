// SPDX-License-Identifier: Apache-2.0
#include "apps/view/loop_history.h"

#include <gmock/gmock.h>

#include "apps/view/test_scene.h"
#include "covis/map/test_map.h"

namespace covis::view {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

class LoopHistoryTest : public testing::Test {
 protected:
  LoopHistoryTest() {
    first_ = map_.write()->add_key_frame(0, 0, at(0).inverse(), some_features());
    second_ = map_.write()->add_key_frame(9, 9, at(1).inverse(), some_features());
  }
  static FeaturesPtr some_features() { return std::make_shared<Features>(); }
  LoopHistory::Change report(LoopOutcome outcome, double full_adjustment_ms = 0) {
    MappingReport made;
    made.frame = 9;
    made.loop.outcome = outcome;
    made.loop.drift.distance = 2;
    made.full_adjustment_ms = full_adjustment_ms;
    return history_.look(map_, {made});
  }
  void move_second_to(double x) { map_.write()->correct_pose(second_, at(x).inverse(), 1); }

  SharedMap map_;
  KeyFrameId first_, second_;
  LoopHistory history_;
};

TEST_F(LoopHistoryTest, KeepsThePathBeforeAndAfter) {
  EXPECT_EQ(report(LoopOutcome::none), LoopHistory::Change::none);
  move_second_to(3);
  EXPECT_EQ(report(LoopOutcome::closed), LoopHistory::Change::loops);
  ASSERT_THAT(history_.loops(), SizeIs(1));
  const LoopPaths& loop = history_.loops().front();
  EXPECT_EQ(loop.frame, 9);
  EXPECT_FLOAT_EQ(loop.correction, 2);
  ASSERT_THAT(loop.before, SizeIs(2));
  EXPECT_FLOAT_EQ(loop.before[1].position[0], 1);
  EXPECT_FLOAT_EQ(loop.after[1].position[0], 3);
  EXPECT_EQ(loop.after[1].submap, map_.read()->at(second_).submap);
}

TEST_F(LoopHistoryTest, TheReportMayComeAfterTheMapHasMoved) {
  report(LoopOutcome::none);
  move_second_to(3);
  report(LoopOutcome::none);
  report(LoopOutcome::joined);
  ASSERT_THAT(history_.loops(), SizeIs(1));
  EXPECT_EQ(history_.loops().front().kind, LoopPaths::Kind::joined);
  EXPECT_FLOAT_EQ(history_.loops().front().before[1].position[0], 1);
}

TEST_F(LoopHistoryTest, AFullAdjustmentRefinesTheNewestLoop) {
  report(LoopOutcome::none);
  move_second_to(3);
  report(LoopOutcome::closed);
  move_second_to(4);
  EXPECT_EQ(report(LoopOutcome::none, 50), LoopHistory::Change::loops);
  EXPECT_FLOAT_EQ(history_.loops().front().after[1].position[0], 4);
  EXPECT_FLOAT_EQ(history_.loops().front().before[1].position[0], 1);
}

TEST_F(LoopHistoryTest, WithoutReportsItDoesNothing) {
  EXPECT_EQ(history_.look(map_, {}), LoopHistory::Change::none);
  EXPECT_THAT(history_.loops(), IsEmpty());
}

}  // namespace
}  // namespace covis::view
