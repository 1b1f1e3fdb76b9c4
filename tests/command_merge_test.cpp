// SPDX-License-Identifier: Apache-2.0
// covis map merge, as people run it: its report, what loads the file it writes, and what it refuses.
#include <cstdlib>

#include "command_results.h"
#include "covis/core/random.h"

namespace covis {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CommandMerge : public CommandTest {
 protected:
  // Two maps of one walk through a room, which share some of it. Made once; each case gets copies.
  void SetUp() override {
    CommandTest::SetUp();
    one = folder / "one.m";
    two = folder / "two.m";
    recording = folder / "room";
    if (maps_.first.empty()) {
      const Outcome made = covis({"synth", "room", "--sensor", "rgbd", "--frames", "90", "--fps", "8", "--width", "320",
                                  "--height", "240", "--quiet", "--out", recording});
      ASSERT_EQ(made.code, 0) << made.error;
      maps_ = {map_of("0", "60"), map_of("30", "60")};
      fs::rename(recording, kept());
    }
    fs::copy(kept(), recording, fs::copy_options::recursive);
    std::ofstream(one, std::ios::binary) << maps_.first;
    std::ofstream(two, std::ios::binary) << maps_.second;
  }
  static void TearDownTestSuite() { fs::remove_all(kept()); }
  std::string map_of(const std::string& first, const std::string& count, std::vector<std::string> more = {}) const {
    const fs::path file = folder / "made.m";
    std::vector<std::string> words{"run",     recording, "--first",      first,        "--count", count,
                                   "--quiet", "--out",   folder / "out", "--save-map", file};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome run = covis(words);
    EXPECT_EQ(run.code, 0) << run.error;
    const std::string map = text_of(file);
    fs::remove(file);
    return map;
  }
  Outcome merge(std::vector<std::string> more) const {
    std::vector<std::string> words{"map", "merge"};
    words.insert(words.end(), more.begin(), more.end());
    return covis(words);
  }

  fs::path recording, one, two;

 private:
  static fs::path kept() {
    return fs::path(testing::TempDir()) / ("covis_CommandMerge_kept_" + std::to_string(getpid()));
  }

  inline static std::pair<std::string, std::string> maps_;
};

TEST_F(CommandMerge, WritesAMapThatAllElseLoads) {
  const fs::path site = folder / "site.m";
  const std::string before = text_of(one) + text_of(two);
  const Outcome made = merge({one, two, "--out", site, "--json"});
  ASSERT_EQ(made.code, 0) << made.error;
  const json report = json::parse(made.out, nullptr, false);
  ASSERT_TRUE(report.is_object()) << made.out;
  EXPECT_EQ(report["inputs"][1]["maps"], json::array({0}));
  ASSERT_EQ(report["pairs"].size(), 1u);
  ASSERT_EQ(report["pairs"][0]["joined"], true) << made.out;
  EXPECT_GE(report["pairs"][0]["claims"], 3);
  EXPECT_GT(report["pairs"][0]["fused"], 50);
  EXPECT_EQ(report["maps"].size(), 1u);
  EXPECT_EQ(text_of(one) + text_of(two), before) << "the inputs stay as they are";

  const Outcome text = merge({one, two, "--out", folder / "again.m"});
  EXPECT_THAT(text.out, AllOf(HasSubstr("joined"), HasSubstr("points found again"), HasSubstr(one.string())));
  EXPECT_EQ(text_of(folder / "again.m"), text_of(site)) << "the same bytes";

  EXPECT_EQ(covis({"map", "check", site}).code, 0);
  EXPECT_EQ(json::parse(covis({"map", "info", site, "--json"}).out, nullptr, false)["maps"], 1);
  EXPECT_EQ(covis({"map", "export", site, "--to", "bundler", "--out", folder / "bundler"}).code, 0);
  const fs::path found = folder / "found.txt";
  ASSERT_EQ(covis({"localize", recording, "--map", site, "--out", found}).code, 0);
  EXPECT_GE(line_count(found), 80) << "of both parts of the walk";
  ASSERT_EQ(covis({"run", recording, "--quiet", "--out", folder / "out", "--map", site, "--save-map", site}).code, 0);
  EXPECT_EQ(parsed(folder / "out/summary.json")["maps"].size(), 1u);
  EXPECT_EQ(covis({"map", "check", site}).code, 0);
}

TEST_F(CommandMerge, RefusesWhatItCanNotDoAndWritesNothing) {
  const fs::path site = folder / "site.m", other = folder / "other.m", broken = folder / "broken.m";
  const Outcome twice = merge({one, one, "--out", site});
  EXPECT_EQ(twice.code, 1);
  EXPECT_THAT(twice.error, HasSubstr(one.string() + ": given twice"));
  const Outcome over = merge({one, two, "--out", two});
  EXPECT_EQ(over.code, 1);
  EXPECT_THAT(over.error, HasSubstr("left as they are"));
  EXPECT_THAT(merge({one, broken, "--out", folder / "no/m"}).error, HasSubstr("no/m: it can't be written"))
      << "before all else: an input is not there";
  const std::string bytes = text_of(one);
  const auto prune = [&](const fs::path& out) {
    return covis({"map", "prune", one, "--key-frames", "3", "--vocabulary", "none", "--out", out});
  };
  EXPECT_THAT(prune(one).error, HasSubstr("left as they are"));
  EXPECT_THAT(prune(folder / "no/m").error, HasSubstr("no/m: it can't be written"));
  EXPECT_EQ(text_of(one), bytes);
  EXPECT_EQ(merge({one, "--out", site}).code, 2) << "one map alone";
  EXPECT_THAT(merge({one, two, "--out", site, "--set", "loop.max_drift=0"}).error,
              AllOf(HasSubstr("--set loop.max_drift=0: maps are merged without asking for it"),
                    HasSubstr("loop.merge_min_found_share")));

  std::ofstream(other, std::ios::binary) << map_of("0", "20", {"--set", "orb.scale_factor=1.3"});
  const Outcome factor = merge({one, other, "--out", site});
  EXPECT_EQ(factor.code, 1);
  EXPECT_THAT(factor.error, AllOf(HasSubstr(other.string() + ": it can't be merged with " + one.string()),
                                  HasSubstr("orb.scale_factor 1.3 instead of 1.2")));

  std::ofstream(broken, std::ios::binary) << text_of(two).substr(0, 2000);
  EXPECT_EQ(merge({one, broken, "--out", site}).code, 1);
  EXPECT_FALSE(fs::exists(site));
}

// The same walk by another camera, with and without its depth. Errors are those of poses in metres.
TEST_F(CommandMerge, CamerasAndSensorsMayDiffer) {
  const fs::path site = folder / "site.m", other = folder / "other", on = folder / "on.m";
  const auto run = [&](std::vector<std::string> words) {
    const fs::path out = folder / "result";
    words.insert(words.begin(), "run");
    words.insert(words.end(), {"--quiet", "--out", out});
    const Outcome done = covis(words);
    EXPECT_EQ(done.code, 0) << done.error;
    const fs::path first = fs::path(words[1]) / "groundtruth.txt";
    const Outcome error = covis({"eval", out / "trajectory.txt", first, "--align", "se3", "--json"});
    EXPECT_EQ(error.code, 0) << error.error;
    const nlohmann::json judged = nlohmann::json::parse(error.out);
    EXPECT_GT(judged["associated"], 30);
    return judged["ate_m"]["rmse"].get<double>();
  };
  const auto info_of = [&](const fs::path& map) {
    return nlohmann::json::parse(covis({"map", "info", map, "--json"}).out);
  };
  const auto camera_of = [&](const fs::path& map) { return info_of(map)["camera"]["width"].get<int>(); };
  // All key frames name a camera of this width, or the map's.
  const auto expect_other = [&](const fs::path& map, int width) {
    const nlohmann::json info = info_of(map);
    ASSERT_EQ(info["other_cameras"].size(), 1u) << info;
    EXPECT_EQ(info["other_cameras"][0]["camera"]["width"], width);
    EXPECT_GT(info["other_cameras"][0]["key_frames"], 2);
    EXPECT_LT(info["other_cameras"][0]["key_frames"], info["key_frames"]);
  };
  ASSERT_EQ(covis({"synth", "room", "--sensor", "rgbd", "--frames", "90", "--fps", "8", "--width", "400", "--height",
                   "300", "--focal", "330", "--quiet", "--out", other})
                .code,
            0);
  ASSERT_EQ(
      covis({"run", other, "--sensor", "mono", "--first", "20", "--quiet", "--out", folder / "out", "--save-map", two})
          .code,
      0);
  for (const auto& [first, second] : {std::pair(one, two), std::pair(two, one)}) {
    const Outcome merged = merge({first, second, "--out", site, "--json"});
    ASSERT_EQ(merged.code, 0) << merged.error;
    EXPECT_EQ(nlohmann::json::parse(merged.out)["maps"].size(), 1u) << merged.out;
    EXPECT_EQ(nlohmann::json::parse(covis({"map", "info", site, "--json"}).out)["sensor"], "rgbd");
    EXPECT_EQ(camera_of(site), 320);
    expect_other(site, 400);
    EXPECT_LT(run({other, "--sensor", "mono", "--count", "40", "--map", site, "--localize"}), 0.03);
  }
  const Outcome refused =
      covis({"run", other, "--sensor", "mono", "--map", site, "--quiet", "--out", folder / "refused"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.error, HasSubstr("--localize"));
  // A map that another camera continues is that camera's; the first one is found in it, and continues it in turn.
  EXPECT_LT(run({other, "--first", "50", "--map", one, "--save-map", on}), 0.02);
  EXPECT_EQ(camera_of(on), 400);
  expect_other(on, 320);
  EXPECT_LT(run({recording, "--count", "60", "--map", on, "--save-map", on}), 0.02);
  EXPECT_EQ(camera_of(on), 320);
  expect_other(on, 400);
  EXPECT_LT(run({other, "--map", on, "--localize"}), 0.02);
  // A camera without depth leaves a map in metres as it is.
  EXPECT_LT(run({other, "--sensor", "mono", "--count", "40", "--map", on, "--localize", "--save-map", on}), 0.03);
  EXPECT_LT(run({recording, "--count", "60", "--map", on, "--save-map", on}), 0.02);
}

// Two cameras of different lenses: what is exported of their map has both, and the image of every key frame.
TEST_F(CommandMerge, ImagesAndCamerasAreExported) {
  const fs::path other = folder / "other", site = folder / "site.m", model = folder / "model";
  ASSERT_EQ(covis({"synth", "room", "--sensor", "rgbd", "--frames", "90", "--fps", "8", "--width", "400", "--height",
                   "300", "--focal", "330", "--distortion", "1", "--quiet", "--out", other})
                .code,
            0);
  for (const auto& [map, from, first] : {std::tuple(one, recording, "0"), std::tuple(two, other, "30")}) {
    ASSERT_EQ(covis({"run", from, "--first", first, "--count", "50", "--quiet", "--out", folder / "out", "--save-map",
                     map, "--keep-images"})
                  .code,
              0);
  }
  const Outcome merged = merge({one, two, "--out", site, "--keep-images", "--json"});
  ASSERT_EQ(merged.code, 0) << merged.error;
  const auto key_frames = json::parse(merged.out)["key_frames"].get<size_t>();
  ASSERT_EQ(json::parse(merged.out)["maps"].size(), 1u);
  const Outcome exported = covis({"map", "export", site, "--to", "nerfstudio", "--out", model});
  ASSERT_EQ(exported.code, 0) << exported.error;
  const json transforms = parsed(model / "transforms.json"), frames = transforms["frames"];
  EXPECT_FALSE(transforms.contains("fl_x") || transforms.contains("w")) << "readers would take them for all frames";
  EXPECT_EQ(frames.size(), key_frames) << "each has its image";
  std::map<int, int> widths;
  for (const json& frame : frames) {
    EXPECT_TRUE(fs::exists(model / frame["file_path"].get<std::string>()));
    ++widths[frame["w"].get<int>()];
  }
  EXPECT_EQ(widths.size(), 2u);
  EXPECT_GT(widths[320], 2);
  EXPECT_GT(widths[400], 2);
  ASSERT_EQ(covis({"map", "export", site, "--to", "colmap", "--out", model}).code, 0);
  EXPECT_EQ(line_count(model / "sparse/0/cameras.txt"), 2);
}

TEST_F(CommandMerge, EndsAtOnceByCtrlC) {
  const fs::path site = folder / "site.m";
  const std::string before = text_of(one) + text_of(two);
  const auto files = [&] { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); };
  covis({"version"});  // makes the files of the output
  const auto count = files();
  int code = 0;
  for (int tried = 0; tried < 5 && code == 0; ++tried) {  // a machine so busy that the merge ends first tries again
    fs::remove(site);
    Process process(command({"map", "merge", one, two, "--out", site}), folder / "stdout", folder / "stderr");
    while (text_of(folder / "stderr").find("places that they share") == std::string::npos && !process.ended())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    process.send(SIGINT);
    code = process.wait(kPatience);
  }
  ASSERT_EQ(code, 128 + SIGINT) << text_of(folder / "stderr");
  EXPECT_FALSE(fs::exists(site));
  EXPECT_EQ(files(), count) << "nothing is left behind";
  EXPECT_EQ(text_of(one) + text_of(two), before) << "the inputs stay as they are";
}

// Over a map that is there: it stays, or the merged one is there in its place.
TEST_F(CommandMerge, KilledWhileMerging) {
  const fs::path site = folder / "site.m";
  const std::string before = text_of(one) + text_of(two), old = text_of(one);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(merge({one, two, "--out", site}).code, 0);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string merged = text_of(site);
  Random random(13);
  const char* const wanted = std::getenv("COVIS_KILLS");  // 200 for a thorough look
  const int rounds = wanted ? std::atoi(wanted) : 3;
  for (int round = 0; round < rounds; ++round) {
    std::ofstream(site, std::ios::binary) << old;
    Process process(command({"map", "merge", one, two, "--out", site}), folder / "stdout", folder / "stderr");
    const double share = round % 2 ? random.uniform(0, 0.8) : random.uniform(0.8, 1.1);  // saving is at the end
    std::this_thread::sleep_for(std::chrono::duration<double>(share * seconds));
    process.send(SIGKILL);
    process.wait(kPatience);
    const std::string left = text_of(site);
    ASSERT_TRUE(left == old || left == merged) << "round " << round;
    ASSERT_EQ(text_of(one) + text_of(two), before) << "round " << round;
  }
  ASSERT_EQ(merge({one, two, "--out", site}).code, 0);
  for (const auto& entry : fs::directory_iterator(folder)) {
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("tmp"))) << "the next saving removes it";
  }
}

TEST_F(CommandMerge, PartsOfAMapAreMaps) {
  const fs::path few = folder / "few.m", parts = folder / "parts";
  const Outcome pruned = covis({"map", "prune", one, "--points", "300", "--out", few, "--json"});
  ASSERT_EQ(pruned.code, 0) << pruned.error;
  const json cost = json::parse(pruned.out, nullptr, false);
  EXPECT_EQ(cost["points"][1], 300) << pruned.out;
  EXPECT_EQ(cost["views_taken_out"], 0);
  EXPECT_GE(cost["left_found_again"], 1);
  EXPECT_EQ(covis({"map", "check", few}).code, 0);
  EXPECT_EQ(covis({"map", "prune", one, "--out", few}).code, 2) << "a budget is needed";

  const auto split = [&](std::vector<std::string> areas) {
    std::vector<std::string> words{"map", "split", one, "--out", parts};
    words.insert(words.end(), areas.begin(), areas.end());
    return covis(words);
  };
  EXPECT_THAT(split({"--around", "0,0,0,0"}).error, HasSubstr("--around 0,0,0,0: the fourth number is a radius"));
  const Outcome made = split({"--around", "-0.1,0,0,0.5", "--box", "-100,-100,-100,100,100,100"});
  ASSERT_EQ(made.code, 0) << made.error;
  const auto key_frames = [&](const fs::path& file) {
    return json::parse(covis({"map", "info", file, "--json"}).out, nullptr, false)["key_frames"].get<int>();
  };
  EXPECT_LT(key_frames(parts / "area0.m"), key_frames(one));
  EXPECT_EQ(key_frames(parts / "area1.m"), key_frames(one)) << "all of it";
  EXPECT_EQ(covis({"map", "check", parts / "area0.m"}).code, 0);
  EXPECT_THAT(split({"--around", "1,2,x,4"}).error, HasSubstr("--around 1,2,x,4: it must be 4 numbers"));
  fs::remove_all(parts);
  EXPECT_THAT(split({"--around", "-0.1,0,0,0.5", "--box", "1000,0,0,1001,1,1"}).error,
              HasSubstr("area 1: no key frame lies there"));
  EXPECT_FALSE(fs::exists(parts));
}

}  // namespace
}  // namespace covis
