// SPDX-License-Identifier: Apache-2.0
// `covis run` as people use it: its files, and that they do not depend on how busy the machine is.
#include <algorithm>
#include <set>

#include "command_results.h"
#include "covis/storage/map_file.h"

namespace covis {
namespace {

using testing::HasSubstr;

volatile std::sig_atomic_t own_signals = 0;

// With a signal that nobody else minds: it would come to this process and all of its group.
TEST(Process, ASignalAfterItsEndReachesNobody) {
  const auto before = std::signal(SIGWINCH, [](int) { own_signals = own_signals + 1; });
  Process process({"/bin/true"}, "/dev/null", "/dev/null");
  EXPECT_EQ(process.wait(std::chrono::seconds(60)), 0);
  process.send(SIGWINCH);
  EXPECT_EQ(own_signals, 0);
  std::signal(SIGWINCH, before);
}

using CommandRun = CommandTest;

TEST_F(CommandRun, WritesAllItsFilesForEachSensor) {
  for (const std::string sensor : {"mono", "stereo", "rgbd"}) {
    SCOPED_TRACE(sensor);
    const fs::path recording = render(sensor, 30), out = folder / ("out_" + sensor);
    const Outcome run = covis({"run", recording, "--out", out, "--json"});
    ASSERT_EQ(run.code, 0) << run.error;
    EXPECT_EQ(expect_results(out), 30);
    EXPECT_EQ(json::parse(run.out, nullptr, false), parsed(out / "summary.json"));
    const json summary = parsed(out / "summary.json");
    EXPECT_EQ(summary["sensor"], sensor);
    EXPECT_EQ(summary["interrupted"], false);
    EXPECT_GE(summary["frames_tracked"].get<int>(), sensor == "mono" ? 20 : 30);
    EXPECT_LT(summary["ate_m"].get<double>(), 0.05) << "truth lies beside the recording";
    EXPECT_EQ(text_of(out / "trajectory.png").substr(1, 3), "PNG");
  }
}

// The key frames' images are kept beside the map, under their ids, and no others.
TEST_F(CommandRun, KeepsTheImagesOfKeyFramesBesideTheMapLong) {
  const fs::path recording = render("rgbd", 40), map = folder / "m.covis", images = folder / "m.covis.images";
  ASSERT_EQ(covis({"run", recording, "--quiet", "--out", folder / "out", "--keep-images"}).code, 1)
      << "there is no map to keep them beside";
  fs::create_directories(images);
  std::ofstream(images / "000999.png") << "of something else";
  const Outcome other = covis({"run", recording, "--out", folder / "out", "--save-map", map, "--keep-images"});
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.error, HasSubstr("holds other things"));
  fs::remove(images / "000999.png");
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{"run",          recording,    "--quiet", "--out",
                                 folder / "out", "--save-map", map,       "--keep-images"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = covis(all);
    ASSERT_EQ(outcome.code, 0) << outcome.error;
    const auto saved = storage::load_map(map);
    ASSERT_TRUE(saved) << saved.error().message;
    std::set<std::string> wanted{"images.txt"}, found;
    for (const KeyFrameId& id : saved->map.key_frames()) {
      char name[16];
      std::snprintf(name, sizeof name, "%06u.png", saved->map.at(id).serial);
      wanted.insert(name);
      EXPECT_FALSE(saved->map.at(id).colours) << "rendered recordings are grey";
    }
    for (const auto& entry : fs::directory_iterator(images)) found.insert(entry.path().filename());
    EXPECT_EQ(found, wanted);
    EXPECT_GE(found.size(), 3u);
  };
  run({"--count", "30"});
  run({"--map", map});  // continued: the images of the earlier key frames stay
}

TEST_F(CommandRun, WritesTheFormatAskedFor) {
  const fs::path recording = render("rgbd", 10);
  ASSERT_EQ(covis({"run", recording, "--quiet", "--format", "kitti", "--out", folder / "kitti"}).code, 0);
  ASSERT_EQ(covis({"run", recording, "--quiet", "--format", "euroc", "--out", folder / "euroc"}).code, 0);
  std::istringstream first(text_of(folder / "kitti" / "trajectory.txt"));
  std::string line;
  std::getline(first, line);
  std::istringstream numbers(line);
  EXPECT_EQ(std::distance(std::istream_iterator<double>(numbers), {}), 12);
  EXPECT_THAT(text_of(folder / "euroc" / "trajectory.txt"), HasSubstr(","));
}

TEST_F(CommandRun, TakesPartOfARecording) {
  const fs::path recording = render("rgbd", 20);
  ASSERT_EQ(covis({"run", recording, "--first", "4", "--count", "5", "--stride", "2", "--out", folder / "out"}).code,
            0);
  std::vector<int> frames;
  for (const json& line : parsed_lines(folder / "out" / "stats.jsonl")) frames.push_back(line["frame"]);
  EXPECT_EQ(frames, (std::vector{4, 6, 8, 10, 12}));
}

// Contents of the trajectory files of one run.
std::string trajectories(const fs::path& out) {
  return text_of(out / "trajectory.txt") + text_of(out / "trajectory_online.txt") + text_of(out / "keyframes.txt");
}

TEST_F(CommandRun, GivesTheSameBytesOnOneCoreAndOnABusyMachineLong) {
  for (const std::string sensor : {"mono", "stereo", "rgbd"}) {
    SCOPED_TRACE(sensor);
    const fs::path recording = render(sensor, 30);
    ASSERT_EQ(covis({"run", recording, "--quiet", "--out", folder / "idle"}).code, 0);
    {
      const Process busy({"/bin/sh", "-c", "while :; do :; done"}, "/dev/null", "/dev/null", true);
      ASSERT_EQ(covis({"run", recording, "--quiet", "--out", folder / "busy"}, true).code, 0);
    }
    EXPECT_GT(line_count(folder / "idle" / "trajectory.txt"), 5);
    EXPECT_EQ(trajectories(folder / "busy"), trajectories(folder / "idle"));
    EXPECT_EQ(text_of(folder / "busy" / "map.ply"), text_of(folder / "idle" / "map.ply"));
  }
}

// A gap of four seconds in a walk along equal posters: the first place recognised after it proves wrong.
TEST_F(CommandRun, TellsPosesThatWereTakenBackAndFoundAfterwardsLong) {
  const fs::path recording = folder / "posters", out = folder / "out";
  ASSERT_EQ(covis({"synth", "posters", "--sensor", "rgbd", "--fps", "10", "--frames", "200", "--width", "320",
                   "--height", "240", "--quiet", "--out", recording})
                .code,
            0);
  std::istringstream lines(text_of(recording / "associations.txt"));
  std::ofstream cut(recording / "associations.txt");
  int frame = 0;
  for (std::string line; std::getline(lines, line);) {
    const bool comment = line[0] == '#';
    if (comment || frame < 50 || frame >= 90) cut << line << "\n";
    frame += !comment;
  }
  cut.close();
  ASSERT_EQ(covis({"run", recording, "--quiet", "--out", out}).code, 0);
  int afterwards = 0, tracked = 0;
  for (const json& line : parsed_lines(out / "stats.jsonl")) {
    tracked += line["state"] == "tracking";
    EXPECT_EQ(line["state"] == "tracking", line.contains("map")) << "the map that its pose is in";
    EXPECT_EQ(line["state"] == "tracking", line["reason"] == "");
    if (line["method"] != "backtracked") continue;
    ++afterwards;
    EXPECT_FALSE(line.contains("online")) << "it had no pose when it was tracked, or one that was taken back";
    EXPECT_EQ(line["tentative"], false);
  }
  EXPECT_GE(afterwards, 1);
  const json summary = parsed(out / "summary.json");
  EXPECT_EQ(summary["frames_tracked"], tracked);
  EXPECT_EQ(line_count(out / "trajectory.txt") + line_count(out / "trajectory_map1.txt"), tracked);
  int lost = 0;
  for (const json& loss : summary["not_tracked"]) lost += loss["last"].get<int>() - loss["first"].get<int>() + 1;
  EXPECT_EQ(tracked + lost, 160);
}

// A camera carried from a desk to another room during the recording, which makes two maps that are not joined.
class CommandMaps : public CommandTest {
 protected:
  // Frames of each place: more than the second for which a pose after a jump is tentative.
  static constexpr int kFrames = 36;

  // Makes one recording in which the room's frames follow the desk's.
  fs::path record_both() const {
    const fs::path desk = render("rgbd", kFrames), room = render("rgbd", kFrames, "room");
    std::istringstream lines(text_of(room / "associations.txt"));
    std::ofstream all(desk / "associations.txt", std::ios::app);
    all.precision(9);
    for (std::string line; std::getline(lines, line);) {
      double stamp = 0, depth_stamp = 0;
      std::string image, depth;
      std::istringstream fields(line);
      if (!(fields >> stamp >> image >> depth_stamp >> depth)) continue;  // a comment line
      all << std::fixed << stamp + 10 << " " << (room / image).string() << " " << depth_stamp + 10 << " "
          << (room / depth).string() << "\n";
    }
    return desk;
  }
  // Number of frames with a pose, by map.
  static std::map<int, int> frames_by_map(const fs::path& out) {
    std::map<int, int> count;
    for (const json& line : parsed_lines(out / "stats.jsonl")) {
      if (line.contains("map")) ++count[line["map"].get<int>()];
    }
    return count;
  }
  void expect_two_maps(const fs::path& out) const {
    const json summary = parsed(out / "summary.json");
    ASSERT_EQ(summary["maps"].size(), 2u);
    EXPECT_EQ(summary["merges"], json::array());
    const auto by_map = frames_by_map(out);
    int tracked = 0;
    for (const int map : {0, 1}) {
      const json& of = summary["maps"][static_cast<size_t>(map)];
      EXPECT_GE(of["frames"].get<int>(), kFrames / 2);
      EXPECT_EQ(by_map.at(map), of["frames"].get<int>());
      tracked += of["frames"].get<int>();
    }
    EXPECT_EQ(summary["frames_tracked"], tracked);
    EXPECT_EQ(line_count(out / "trajectory.txt"), by_map.at(0));
    EXPECT_EQ(line_count(out / "trajectory_map1.txt"), by_map.at(1));
    EXPECT_FALSE(fs::exists(out / "trajectory_map2.txt"));
    EXPECT_THAT(text_of(out / "report.html"), HasSubstr("maps, not joined"));
  }
};

TEST_F(CommandMaps, AreWrittenSavedAndLocalisedInEachByItselfLong) {
  const fs::path recording = record_both(), out = folder / "out", map = folder / "m.covis";
  const Outcome run = covis(
      {"run", recording, "--out", out, "--save-map", map, "--set", "tracker.new_map_after=0.2", "--simd", "scalar"});
  ASSERT_EQ(run.code, 0) << run.error;
  ASSERT_NO_FATAL_FAILURE(expect_two_maps(out));
  EXPECT_THAT(run.out, HasSubstr("2 maps that could not be joined"));
  EXPECT_EQ(json::parse(covis({"map", "info", map, "--json"}).out, nullptr, false)["maps"], 2);
  EXPECT_THAT(covis({"map", "info", map}).out, HasSubstr("maps            2, not joined"));
  EXPECT_EQ(covis({"map", "check", map}).code, 0);

  // Locates the images one by one, then as a recording that leaves the map unchanged.
  const fs::path found = folder / "found.txt", found_in_1 = folder / "found_map1.txt";
  const Outcome localize = covis({"localize", recording, "--map", map, "--out", found, "--json"});
  ASSERT_EQ(localize.code, 0) << localize.error;
  EXPECT_GE(line_count(found), kFrames - 2);
  EXPECT_GE(line_count(found_in_1), kFrames - 2);
  EXPECT_EQ(json::parse(localize.out, nullptr, false)["localized"], line_count(found) + line_count(found_in_1));
  const fs::path again = folder / "again";
  ASSERT_EQ(covis({"run", recording, "--quiet", "--out", again, "--map", map, "--localize"}).code, 0);
  ASSERT_NO_FATAL_FAILURE(expect_two_maps(again));
  const json summary = parsed(again / "summary.json");
  for (const json& m : summary["maps"]) EXPECT_EQ(m["loaded"], true);
  EXPECT_EQ(summary["keyframes"], parsed(out / "summary.json")["keyframes"]);

  // A run with one map leaves no files of the second map behind.
  ASSERT_EQ(
      covis({"run", recording, "--count", std::to_string(kFrames), "--quiet", "--out", out, "--save-map", map}).code,
      0);
  EXPECT_FALSE(fs::exists(out / "trajectory_map1.txt"));
  EXPECT_EQ(parsed(out / "summary.json")["maps"].size(), 1u);
  expect_results(out);
  ASSERT_EQ(covis({"localize", recording, "--map", map, "--out", found}).code, 0);
  EXPECT_FALSE(fs::exists(found_in_1));
  // The camera relocalises in a loaded map, which is continued.
  ASSERT_EQ(covis({"run", recording, "--count", "10", "--quiet", "--out", again, "--map", map}).code, 0);
  EXPECT_EQ(parsed(again / "summary.json")["maps"][0]["loaded"], true);
  EXPECT_FALSE(fs::exists(again / "trajectory_map1.txt"));
}

// Starts a run, interrupts it `after` seconds from the start of tracking, and keeps its exit code.
class CommandInterrupt : public CommandTest {
 protected:
  void interrupt(const std::vector<std::string>& words, double after, int signal = SIGINT) {
    const fs::path out = folder / "out";
    fs::remove_all(out);
    std::vector<std::string> all{"run", "--out", out};
    all.insert(all.end(), words.begin(), words.end());
    Process process(command(all), folder / "stdout", folder / "stderr");
    // The output folder is created just before tracking starts.
    while (!fs::exists(out) && !process.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::duration<double>(after));
    const auto sent = std::chrono::steady_clock::now();
    process.send(signal);
    code = process.wait(std::chrono::seconds(10));
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - sent).count();
    std::printf("%.2f s after the start: ended with %d within %.3f s\n", after, code, seconds);
  }

  void expect_interrupted_or_done(int frames) const {
    ASSERT_THAT(code, testing::AnyOf(128 + SIGINT, 0)) << text_of(folder / "stderr");
    const int taken = expect_results(folder / "out");
    const bool interrupted = code != 0;
    EXPECT_EQ(parsed(folder / "out" / "summary.json")["interrupted"], interrupted);
    EXPECT_LE(taken, frames);
    if (!interrupted) {
      EXPECT_EQ(taken, frames);
    }
    EXPECT_EQ(text_of(folder / "stderr").find("interrupted") != std::string::npos, interrupted);
  }

  int code = 0;
  double seconds = 0;  // time from the signal to the end
};

TEST_F(CommandInterrupt, EndsSoonWithAllFilesAtAnyMoment) {
  const fs::path recording = render("stereo", 60);
  // 60 frames take two seconds in real time.
  for (const double after : {0.0, 0.2, 1.0, 1.8}) {
    SCOPED_TRACE(after);
    interrupt({recording, "--realtime"}, after);
    // On a very busy machine the signal may arrive after the end.
    if (after < 0.5) {
      ASSERT_EQ(code, 128 + SIGINT) << text_of(folder / "stderr");
    }
    expect_interrupted_or_done(60);
  }
}

TEST_F(CommandInterrupt, EndsSoonWhileMappingRuns) {
  const fs::path recording = render("rgbd", 60);
  for (const double after : {0.0, 0.02, 0.05, 0.1, 0.2, 0.4}) {
    SCOPED_TRACE(after);
    interrupt({recording}, after);
    expect_interrupted_or_done(60);
  }
}

TEST_F(CommandInterrupt, AClosedTerminalEndsARunInOrder) {
  const fs::path recording = render("rgbd", 60);
  interrupt({recording, "--realtime"}, 0.2, SIGHUP);
  EXPECT_EQ(code, 128 + SIGHUP);
  expect_results(folder / "out");
}

TEST_F(CommandInterrupt, TerminationIsToldFromCtrlC) {
  const fs::path recording = render("rgbd", 60);
  interrupt({recording, "--realtime"}, 0.2, SIGTERM);
  EXPECT_EQ(code, 128 + SIGTERM);
  expect_results(folder / "out");
}

TEST_F(CommandInterrupt, BeforeTheCommandIsUpLeavesNothingHalf) {
  const fs::path recording = render("rgbd", 10), out = folder / "out";
  for (int milliseconds = 0; milliseconds < 10; ++milliseconds) {
    fs::remove_all(out);
    Process process(command({"run", recording, "--quiet", "--out", out}), folder / "stdout", folder / "stderr");
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    process.send(SIGINT);
    const int ended = process.wait(std::chrono::seconds(10));
    ASSERT_THAT(ended, testing::AnyOf(128 + SIGINT, 0));
    if (fs::exists(out)) expect_results(out);
  }
}

}  // namespace
}  // namespace covis
