// SPDX-License-Identifier: Apache-2.0
// A run whose map is bounded: it says so, keeps every frame's pose, and is as reproducible as any other.
#include "command_results.h"

namespace covis {
namespace {

using testing::HasSubstr;

class CommandMemory : public CommandTest {};

TEST_F(CommandMemory, AMapThatReachesItsBoundIsThinned) {
  const fs::path street = folder / "street";
  ASSERT_EQ(covis({"synth", "street", "--sensor", "stereo", "--frames", "220", "--width", "480", "--height", "240",
                   "--quiet", "--out", street})
                .code,
            0);
  const auto run = [&](const std::string& out) {
    return covis({"run", street, "--no-colours", "--set", "mapper.max_map_mb=5", "--out", folder / out});
  };
  const Outcome one = run("one"), two = run("two");
  ASSERT_EQ(one.code, 0) << one.error;
  EXPECT_THAT(one.error, HasSubstr("the map has reached 5 MB"));
  EXPECT_THAT(one.out, HasSubstr("key frames were given up to keep the map within its bound"));
  const json summary = parsed(folder / "one/summary.json");
  const int thinned = summary["keyframes_thinned"];
  EXPECT_GT(thinned, 5);
  EXPECT_GE(summary["keyframes"], 50);
  EXPECT_EQ(summary["frames_tracked"], 220);
  EXPECT_LT(summary["ate_m"], 1);
  int told = 0;
  for (const json& row : parsed_lines(folder / "one/stats.jsonl"))
    told += row.contains("mapping") ? row["mapping"]["key_frames_thinned"].get<int>() : 0;
  EXPECT_EQ(told, thinned);
  for (const char* file : {"trajectory.txt", "trajectory_online.txt", "keyframes.txt", "map.ply"})
    EXPECT_EQ(text_of(folder / "one" / file), text_of(folder / "two" / file)) << file;
  const Outcome little = covis({"run", street, "--quiet", "--max-memory", "100", "--out", folder / "three"});
  EXPECT_EQ(little.code, 1);
  EXPECT_THAT(little.error, HasSubstr("--max-memory 100: images of this size need at least"));
  EXPECT_FALSE(fs::exists(folder / "three")) << "said before anything is made";
}

}  // namespace
}  // namespace covis
