// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_report.h"

#include <gmock/gmock.h>

#include <set>
#include <string>

namespace covis {
namespace {

TEST(LoopReport, EveryRefusalHasANameOfItsOwn) {
  std::set<std::string> names;
  for (int k = 0; k <= static_cast<int>(LoopRefusal::unconfirmed); ++k) {
    const std::string refusal = name(static_cast<LoopRefusal>(k));
    EXPECT_FALSE(refusal.empty()) << k;
    EXPECT_TRUE(names.insert(refusal).second) << refusal;
  }
}

TEST(LoopReport, ARefusalIsToldWithItsFigures) {
  RefusedPlace refused{{}, 17, LoopRefusal::drift_too_great, {200, 172, 230, 241, 400}, {}, {}};
  EXPECT_EQ(describe(refused),
            "no loop to frame 17: drift too great (200 matches, 172 inliers, 230 both ways, 241 of 400 points found "
            "again)");
  refused.drift = {.path = 512, .past = 540, .distance = 34.9, .rotation_deg = 12, .scale = 1};
  refused.link = 40;
  EXPECT_THAT(describe(refused),
              testing::EndsWith(", correction 34.9 of a path of 512 (540 with turns), 12 degrees, scale 1, weakest "
                                "link of 40 points"));
}

TEST(LoopReport, EvidenceKeepsTheGreaterNumbers) {
  LoopEvidence evidence{10, 5, 3, 2, 1};
  evidence.raise_to({9, 6, 2, 4, 0});
  EXPECT_EQ(evidence.matches, 10);
  EXPECT_EQ(evidence.inliers, 6);
  EXPECT_EQ(evidence.both_ways, 3);
  EXPECT_EQ(evidence.found_again, 4);
  EXPECT_EQ(evidence.in_view, 1);
}

TEST(LoopReport, TheMapIsChangedByLoopsAndJoins) {
  for (const LoopOutcome outcome : {LoopOutcome::none, LoopOutcome::fused, LoopOutcome::closed, LoopOutcome::joined}) {
    LoopReport report;
    report.outcome = outcome;
    EXPECT_EQ(report.changed_map(), outcome == LoopOutcome::closed || outcome == LoopOutcome::joined);
  }
}

}  // namespace
}  // namespace covis
