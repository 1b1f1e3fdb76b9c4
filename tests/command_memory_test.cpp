// SPDX-License-Identifier: Apache-2.0
// A run whose map is bounded: it says so, keeps every frame's pose, and is as reproducible as any other.
#include <algorithm>
#include <sstream>

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

// Poses of TUM's format, each with its eight numbers.
bool is_whole(const std::string& trajectory) {
  if (!trajectory.ends_with('\n')) return false;
  std::istringstream lines(trajectory);
  for (std::string line; std::getline(lines, line);) {
    if (std::count(line.begin(), line.end(), ' ') != 7) return false;
  }
  return true;
}

// The limits close in on the least memory that is enough. They lie where libraries are loaded, threads are started,
// frames are tracked, and results are written.
TEST_F(CommandMemory, WhereThereIsTooLittleOneMessageSaysSoAndOlderResultsStay) {
  const fs::path recording = render("rgbd", 12), out = folder / "out", map = folder / "m";
  const auto run = [&](int megabytes) {
    const std::string words = "ulimit -v " + std::to_string(1024 * megabytes) + "; ulimit -c 0; exec " + COVIS_COMMAND +
                              " run " + recording.string() + " --quiet --out " + out.string() + " --save-map " +
                              map.string();
    Process process({"/bin/sh", "-c", words}, folder / "stdout", folder / "stderr");
    return Outcome{process.wait(kPatience), text_of(folder / "stdout"), text_of(folder / "stderr")};
  };
  int enough = 8000, little = 0, refused = 0;
  ASSERT_EQ(run(enough).code, 0);
  const std::string poses = text_of(out / "trajectory.txt"), whole_map = text_of(map);
  while (enough - little > 6) {
    const int megabytes = (enough + little) / 2;
    SCOPED_TRACE(megabytes);
    fs::remove(map);
    std::ofstream(out / "trajectory.txt", std::ios::binary) << poses;
    const Outcome ended = run(megabytes);
    (ended.code == 0 ? enough : little) = megabytes;
    if (ended.code == 0) {
      EXPECT_EQ(text_of(map), whole_map);
    }
    // The system's loader can't even begin.
    if (ended.code == 0 || ended.error.find("while loading shared libraries") != std::string::npos) continue;
    ++refused;
    EXPECT_EQ(ended.code, 1) << ended.error;
    EXPECT_THAT(ended.error, AllOf(HasSubstr("error: "), testing::Not(HasSubstr("bad_alloc")),
                                   testing::Not(HasSubstr("terminate")), testing::Not(HasSubstr("OpenCV"))));
    const std::string left = text_of(out / "trajectory.txt");
    EXPECT_TRUE(left == poses || is_whole(left)) << left;
    const bool tracked = left != poses || ended.error.find("the results so far are written") != std::string::npos;
    const bool told = ended.error.find(map.string() + ": ") != std::string::npos;  // that the map had too little, too
    EXPECT_TRUE(!tracked || told || fs::exists(map)) << ended.error;
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace covis
