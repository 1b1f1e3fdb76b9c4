// SPDX-License-Identifier: Apache-2.0
// Jobs beside other work on the map.
#include "covis/loops/background_adjustment.h"

#include <gtest/gtest.h>

#include "covis/core/test_threads.h"
#include "covis/features/test_features.h"

namespace covis {
namespace {

// A job that ends when it is let go or interrupted.
class HeldJob : public AdjustmentJob {
 public:
  explicit HeldJob(std::atomic<bool>& let_go, bool solved = true) : let_go_(let_go), solved_(solved) {}
  AdjustmentKind kind() const override { return AdjustmentKind::camera; }
  bool run(const std::atomic<bool>& interrupt) override {
    while (!let_go_ && !interrupt) std::this_thread::yield();
    return solved_ && !interrupt;
  }
  std::optional<KeyFrameMoves> apply(SharedMap& map) const override {
    map.write()->count_move();
    return KeyFrameMoves();
  }

 private:
  std::atomic<bool>& let_go_;
  const bool solved_;
};

struct BackgroundAdjustmentTest : testing::Test {
  SharedMap map;
  std::atomic<bool> let_go{false};
  BackgroundAdjustment background;
};

TEST_F(BackgroundAdjustmentTest, WithoutAThreadThereIsNoJob) {
  {
    const NoMoreThreads none;
    background.start(std::make_unique<HeldJob>(let_go), 3);
  }
  EXPECT_FALSE(background.running());
  background.abandon();
  let_go = true;
  background.start(std::make_unique<HeldJob>(let_go), 3);
  EXPECT_TRUE(background.apply(map).applied);
}

TEST_F(BackgroundAdjustmentTest, RunsAJobAndAppliesItsResult) {
  EXPECT_FALSE(background.running());
  background.start(std::make_unique<HeldJob>(let_go), 3);
  EXPECT_TRUE(background.running());
  EXPECT_FALSE(background.ready());
  let_go = true;
  const BackgroundAdjustment::Outcome outcome = background.apply(map);
  EXPECT_EQ(outcome.kind, AdjustmentKind::camera);
  EXPECT_TRUE(outcome.solved);
  EXPECT_TRUE(outcome.applied);
  EXPECT_FALSE(background.running());
  EXPECT_EQ(map.read()->moves(), 1u);
}

TEST_F(BackgroundAdjustmentTest, AResultIsDueAfterAsManyKeyFramesAsTheJobWasGiven) {
  let_go = true;
  background.start(std::make_unique<HeldJob>(let_go), 3);
  for (int k = 0; k < 3; ++k) {
    EXPECT_FALSE(background.due()) << k;
    background.count_key_frame();
  }
  EXPECT_TRUE(background.due());
}

TEST_F(BackgroundAdjustmentTest, AJobWithoutAResultLeavesTheMap) {
  let_go = true;
  background.start(std::make_unique<HeldJob>(let_go, false), 1);
  const BackgroundAdjustment::Outcome outcome = background.apply(map);
  EXPECT_FALSE(outcome.solved);
  EXPECT_FALSE(outcome.applied);
  EXPECT_EQ(map.read()->moves(), 0u);
}

TEST_F(BackgroundAdjustmentTest, AJobIsGivenUpAtAnyTime) {
  background.start(std::make_unique<HeldJob>(let_go), 1);
  background.abandon();
  EXPECT_FALSE(background.running());
  background.start(std::make_unique<HeldJob>(let_go), 1);
  background.start(std::make_unique<HeldJob>(let_go), 1);
  EXPECT_TRUE(background.running()) << "the later one";
  background.start(nullptr, 1);
  EXPECT_FALSE(background.running()) << "there is none";
  background.start(std::make_unique<HeldJob>(let_go), 1);  // the destructor gives it up
}

}  // namespace
}  // namespace covis
