// SPDX-License-Identifier: Apache-2.0
// A run whose map is bounded: it says so, keeps every frame's pose, and is as reproducible as any other.
#include "command_results.h"

namespace covis {
namespace {

using testing::AllOf;
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

// The limits lie where libraries are loaded, threads are started, frames are tracked, and pictures are drawn.
TEST_F(CommandMemory, WhereThereIsTooLittleOneMessageSaysSoAndOlderResultsStay) {
  const fs::path recording = render("rgbd", 12), out = folder / "out";
  const auto run = [&](int megabytes) {
    const std::string words = "ulimit -v " + std::to_string(1024 * megabytes) + "; ulimit -c 0; exec " + COVIS_COMMAND +
                              " run " + recording.string() + " --quiet --out " + out.string() + " --save-map " +
                              (folder / "m").string();
    Process process({"/bin/sh", "-c", words}, folder / "stdout", folder / "stderr");
    return Outcome{process.wait(kPatience), text_of(folder / "stdout"), text_of(folder / "stderr")};
  };
  ASSERT_EQ(run(4000).code, 0);
  const std::string poses = text_of(out / "trajectory.txt"), map = text_of(folder / "m");
  int refused = 0;
  for (int megabytes = 200; megabytes < 300; megabytes += 8) {
    SCOPED_TRACE(megabytes);
    fs::remove(folder / "m");
    std::ofstream(out / "trajectory.txt", std::ios::binary) << poses;
    const Outcome little = run(megabytes);
    if (little.code == 0) {
      EXPECT_EQ(text_of(folder / "m"), map);
      continue;
    }
    ++refused;
    EXPECT_EQ(little.code, 1) << little.error;
    EXPECT_THAT(little.error, AllOf(HasSubstr("error: "), testing::Not(HasSubstr("bad_alloc")),
                                    testing::Not(HasSubstr("terminate")), testing::Not(HasSubstr("OpenCV"))));
    EXPECT_GT(line_count(out / "trajectory.txt"), 0);
  }
  RecordProperty("refused", refused);
}

}  // namespace
}  // namespace covis
