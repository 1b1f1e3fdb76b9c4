// SPDX-License-Identifier: Apache-2.0
// covis eval as people use it.
#include "command_results.h"

namespace covis {
namespace {

using testing::HasSubstr;

using CommandEval = CommandTest;

TEST_F(CommandEval, ComparesARunWithItsTruth) {
  const fs::path recording = render("rgbd", 20), out = folder / "out";
  ASSERT_EQ(covis({"run", recording, "--quiet", "--out", out}).code, 0);
  const Outcome eval = covis({"eval", out / "trajectory.txt", recording / "groundtruth.txt", "--json"});
  ASSERT_EQ(eval.code, 0) << eval.error;
  const json found = json::parse(eval.out, nullptr, false);
  EXPECT_NEAR(found["ate_m"]["rmse"].get<double>(), parsed(out / "summary.json")["ate_m"].get<double>(), 1e-6);
  const Outcome text = covis({"eval", out / "trajectory.txt", recording / "groundtruth.txt", "--align", "sim3"});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.out, HasSubstr("ATE"));
  for (const char* name : {"errors.png", "errors.html"}) {
    EXPECT_EQ(covis({"eval", out / "trajectory.txt", recording / "groundtruth.txt", "--plot", folder / name}).code, 0);
    EXPECT_GT(fs::file_size(folder / name), 10'000u);
  }
  const Outcome other =
      covis({"eval", out / "trajectory.txt", recording / "groundtruth.txt", "--plot", folder / "errors.gif"});
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.error, HasSubstr(".png or .html"));
}

TEST_F(CommandEval, PairsRowsWithoutStampsByTheirNumber) {
  const std::string tum = folder / "tum.txt", kitti = folder / "kitti.txt", tartanair = folder / "pose_left.txt";
  std::ofstream(tum) << "0 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0 1\n0.2 1 0 2 0 0 0 1\n";
  std::ofstream(kitti) << "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 2\n";
  std::ofstream(tartanair) << "0 0 0 0.5 0.5 0.5 0.5\n0 1 0 0.5 0.5 0.5 0.5\n2 1 0 0.5 0.5 0.5 0.5\n";
  for (const std::string& estimate : {kitti, tum}) {
    const Outcome eval = covis({"eval", estimate, tartanair, "--json"});
    ASSERT_EQ(eval.code, 0) << eval.error;
    const json found = json::parse(eval.out, nullptr, false);
    EXPECT_EQ(found["associated"], 3) << estimate;
    EXPECT_LT(found["ate_m"]["rmse"].get<double>(), 1e-6) << estimate;
  }
}

}  // namespace
}  // namespace covis
