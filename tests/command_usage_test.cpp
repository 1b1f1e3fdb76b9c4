// SPDX-License-Identifier: Apache-2.0
// The other commands as people use them, and the codes and messages of all for wrong arguments, input and disks.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "command_results.h"

namespace covis {
namespace {

using testing::HasSubstr;

using CommandCheck = CommandTest;

TEST_F(CommandCheck, SaysWhatARecordingIs) {
  for (const std::string sensor : {"mono", "stereo", "rgbd"}) {
    SCOPED_TRACE(sensor);
    const fs::path picture = folder / (sensor + ".png");
    const Outcome check = covis({"check", render(sensor, 5), "--json", "--out", picture});
    EXPECT_EQ(check.code, 0) << check.error << check.out;
    const json found = json::parse(check.out, nullptr, false);
    EXPECT_EQ(found["sensor"], sensor);
    EXPECT_EQ(found["frames_read"], 5);
    EXPECT_EQ(found["problems"], json::array());
    EXPECT_EQ(text_of(picture).substr(1, 3), "PNG");
  }
}

TEST_F(CommandCheck, NamesTheFrameThatCantBeRead) {
  const fs::path recording = render("rgbd", 5);
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(recording / "rgb")) images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  ASSERT_EQ(images.size(), 5u);
  fs::resize_file(images[2], fs::file_size(images[2]) / 3);
  const Outcome check = covis({"check", recording, "--json", "--out", folder / "c.png"});
  EXPECT_EQ(check.code, 1);
  const json found = json::parse(check.out, nullptr, false);
  ASSERT_EQ(found["problems"].size(), 1u) << check.out;
  EXPECT_EQ(found["problems"][0]["frame"], 2);
  EXPECT_THAT(found["problems"][0]["problem"].get<std::string>(), HasSubstr(images[2].filename().string()));
  // A run goes on without it, and says so.
  const Outcome run = covis({"run", recording, "--quiet", "--out", folder / "out"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.error, HasSubstr(images[2].filename().string()));
  EXPECT_EQ(parsed(folder / "out" / "summary.json")["frames_unreadable"], 1);
}

TEST_F(CommandCheck, MakesACameraFileOfAnotherProgramsCamera) {
  const fs::path chain = folder / "camchain.yaml", camera = folder / "camera.yaml";
  const std::string lens =
      "  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n"
      "  intrinsics: [458, 457, 367, 248]\n  resolution: [752, 480]\n";
  std::ofstream(chain) << "cam0:\n"
                       << lens << "cam1:\n  T_cn_cnm1: [[1, 0, 0, -0.11], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
                       << lens;
  const Outcome made = covis({"check", "--import-camera", chain, "--out", camera});
  EXPECT_EQ(made.code, 0) << made.error;
  EXPECT_THAT(made.out, HasSubstr("Kalibr"));
  EXPECT_THAT(text_of(camera), HasSubstr("fx: 458\n"));
  EXPECT_THAT(text_of(folder / "camera_cam1_sensor.yaml"), HasSubstr("radial-tangential"));
  EXPECT_EQ(covis({"check", "--import-camera", camera, "--out", folder / "c.yaml"}).code, 1) << "it is one already";
  EXPECT_THAT(covis({"check", "--import-camera", chain, "--out", chain}).error, HasSubstr("left as they are"));
  EXPECT_THAT(text_of(chain), HasSubstr("cam1"));
  EXPECT_EQ(covis({"check", folder, "--import-camera", chain}).code, 2) << "one or the other";
  EXPECT_EQ(covis({"check", "--import-camera", chain, "--stride", "2"}).code, 2) << "that is of recordings";
}

TEST_F(CommandCheck, AListThatWasCutShortIsAProblem) {
  const fs::path recording = render("rgbd", 5), list = recording / "depth.txt";
  const std::string whole = text_of(list);
  std::ofstream(list) << whole.substr(0, whole.rfind('\n', whole.size() - 2) + 1);
  fs::remove(recording / "associations.txt");
  const Outcome check = covis({"check", recording, "--json", "--out", folder / "c.png"});
  EXPECT_EQ(check.code, 1) << check.out;
  const json found = json::parse(check.out, nullptr, false);
  ASSERT_EQ(found["problems"].size(), 1u) << check.out;
  EXPECT_THAT(found["problems"][0]["problem"], HasSubstr("1 of 5 images have no depth image"));
  EXPECT_FALSE(found["problems"][0].contains("frame"));
  EXPECT_EQ(found["notes"], json::array()) << "it is said once";
}

TEST_F(CommandCheck, ARateThatNoCameraHasIsSaidByRunToo) {
  const fs::path recording = render("mono", 3), images = folder / "slow";
  fs::create_directories(images);
  for (const auto& entry : fs::directory_iterator(recording / "images"))
    fs::copy(entry.path(), images / entry.path().filename());
  std::ofstream(images / "times.txt") << "0\n33\n66\n";  // milliseconds
  const std::string camera = recording / "camera.yaml", doubt = "are the stamps in seconds";
  EXPECT_THAT(covis({"check", images, "--camera", camera, "--out", folder / "c.png"}).out, HasSubstr(doubt));
  EXPECT_THAT(covis({"run", images, "--camera", camera, "--out", folder / "out"}).error, HasSubstr(doubt));
}

TEST_F(CommandCheck, LeftAndRightSwapped) {
  const fs::path recording = render("stereo", 24);
  fs::rename(recording / "image_0", recording / "left");
  fs::rename(recording / "image_1", recording / "image_0");
  fs::rename(recording / "left", recording / "image_1");
  const Outcome check = covis({"check", recording, "--json", "--out", folder / "c.png"});
  EXPECT_EQ(check.code, 1);
  EXPECT_THAT(check.out, HasSubstr("of the left keypoints have a match in the right image"));
  EXPECT_GT(json::parse(check.out, nullptr, false)["depth_m"]["median"], 0);
  const Outcome run = covis({"run", recording, "--quiet", "--out", folder / "out"});
  EXPECT_THAT(run.error, HasSubstr("of the left keypoints have a match in the right image"));
  EXPECT_EQ(parsed(folder / "out" / "summary.json")["warnings"][0]["kind"], "few_depths");
}

using CommandUsage = CommandTest;

TEST_F(CommandUsage, WrongArgumentsAreNamedWithCode2) {
  const struct {
    std::vector<std::string> words;
    const char* message;
  } cases[] = {
      {{}, "subcommand is required"},
      {{"rnu", "somewhere"}, "rnu: no such command; did you mean covis run?"},
      {{"run", "somewhere", "--sensor", "sonar"}, "sonar not in {mono,rgbd,stereo}"},
      {{"run", "somewhere", "--features", "1"}, "--features: 1 is not a whole number from 50 to 30000"},
      {{"run", "somewhere", "--view=0x1F90"}, "0x1F90 is not a whole number from 0 to 65535"},
      {{"run", "somewhere", "--save-every", "5"}, "--save-every requires --save-map"},
      {{"run", "somewhere", "--stride", "0"}, "--stride: 0 is not a whole number from 1 to 1000000000"},
      {{"run", "somewhere", "--count", "-5"}, "--count: -5 is not a whole number from 1 on, or -1 for all"},
      {{"run", "somewhere", "--first", "-1"}, "--first: -1 is not a whole number from 0 on"},
      {{"run", "somewhere", "--stride", "99999999999"}, "--stride: 99999999999 is not a whole number from 1 to"},
      {{"run", "somewhere", "--camera", ""}, "--camera: its value is empty"},
      {{"synth", "room", "--out", ""}, "--out: its value is empty"},
      {{"map", "inof", "a.m"}, "inof: no such command; did you mean covis map info?"},
      {{"vocab", "trian", "a"}, "trian: no such command; did you mean covis vocab train?"},
      {{"eval", "a", "b", "--delta", "nan"}, "--delta: nan is not a positive number"},
      {{"eval", "a", "b", "--max-difference", "inf"}, "--max-difference: inf is not a positive number"},
      {{"run", "somewhere", "--frobnicate"}, "--frobnicate"},
      {{"run", "--format", "csv"}, "csv not in"},
      {{"eval", "trajectory.txt"}, "TRUTH is required"},
      {{"eval", "a", "b", "--align", "affine"}, "affine not in"},
      {{"check"}, "PATH is required"},
      {{"localize", "somewhere"}, "--map is required"},
      {{"synth", "room"}, "--out is required"}};
  for (const auto& c : cases) {
    const Outcome outcome = covis(c.words);
    EXPECT_EQ(outcome.code, 2) << c.message;
    EXPECT_THAT(outcome.error, HasSubstr(c.message));
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(CommandUsage, WrongInputIsNamedWithCode1) {
  std::ofstream(folder / "file.txt") << "not a trajectory\n";
  const std::string file = folder / "file.txt", gone = folder / "gone", tum = folder / "tum.txt",
                    kitti = folder / "kitti.txt", part = folder / "part.txt", part_times = folder / "part_times.txt";
  std::ofstream(tum) << "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n";
  std::ofstream(part) << "1 0 0 1 0 1 0 0 0 0 1 0\n";
  std::ofstream(part_times) << "1\n";
  std::ofstream(kitti) << "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n";
  const struct {
    std::vector<std::string> words;
    std::string message;
  } cases[] = {
      {{"run"}, "PATH is missing"},
      {{"run", gone}, gone + ": it does not exist"},
      {{"run", gone, "--count", "-1"}, gone + ": it does not exist"},
      {{"run", gone, "--set", "orb.featurs=3"}, "nearest known one is 'orb.features'"},
      {{"run", gone, "--set", "orb.features=x"}, "whole number from 50"},
      {{"run", gone, "--set", "orb.features"}, "NAME=VALUE"},
      {{"run", "--set", "orb.levels=4", gone}, gone + ": it does not exist"},
      {{"run", gone, "--set", "orb.levels=4", "--set", "orb.levels=5"}, "orb.levels is set twice"},
      {{"run", gone, "--features", "500", "--set", "orb.features=900"}, "are the same setting; give one of them"},
      {{"run", gone, "--set", "system.trajectory_frames=9"}, "it is for programs"},
      {{"run", gone, "--config", gone}, gone},
      {{"run", gone, "--set", "mapper.max_map_mb=-1"}, "whole number from 0"},
      {{"run", gone, "--simd", "abacus"}, "no such instruction set here; there are best, "},
      {{"localize", gone, "--map", gone}, gone + ": it does not exist"},
      {{"localize", gone, "--map", gone, "--set", "orb.features"}, "NAME=VALUE"},
      {{"map", "info", gone}, gone},
      {{"run", folder / "camera", "--kind", "camera"}, "a camera is named by its number"},
      {{"run", gone, "--set", "orb.levels=\x1b[2J"}, "orb.levels: '\\x1b[2J' is not right"},
      {{"run", "go\x1b[31mne"}, "go\\x1b[31mne: it does not exist"},
      {{"calibrate", gone, "--board", "9x6", "--square", "0.03"}, gone + ": there is no such video"},
      {{"calibrate", gone, "--board", "9by6", "--square", "0.03"}, "COLUMNSxROWS is wanted"},
      {{"calibrate", gone, "--board", "9x6", "--square", "0.03", "--marker", "0.02"}, "--charuco"},
      {{"eval", gone, gone}, gone},
      {{"eval", file, file}, "file.txt"},
      {{"eval", tum, kitti},
       "kitti.txt: it has no stamps, and " + tum + " has; give those of its rows with --truth-stamps"},
      {{"eval", kitti, tum}, "kitti.txt: it has no stamps, and " + tum + " has; give those of its rows with --stamps"},
      {{"eval", part, kitti}, part + " has 1 rows and " + kitti + " has 2, none with a stamp, so that"},
      {{"eval", part, tum}, "give those of its rows with --stamps " + part_times},
      {{"eval", kitti, tum, "--stamps", part_times},
       kitti + ": it has 2 rows, and " + part_times + " has 1 stamps; a file with one stamp for each"},
      {{"eval", tum, tum, "--stamps", file}, "--stamps " + file + ": " + tum + " has stamps of its own"},
      {{"eval", tum, tum, "--delta", "2.5"}, "a number of frames is whole"},
      {{"eval", tum, tum, "--plot", gone + "/plot.png"}, "gone/plot.png: it can't be written"},
      {{"check", gone}, gone},
      {{"check", "--import-camera", file, "--out", gone}, "it is no camera that can be read. Readable are: Kalibr"},
      {{"synth", "room", "--sensor", "mono", "--baseline", "0.1", "--out", gone},
       "--baseline: it does nothing with --sensor mono"},
      {{"synth", "mars", "--out", gone}, "no world 'mars'"}};
  for (const auto& c : cases) {
    const Outcome outcome = covis(c.words);
    EXPECT_EQ(outcome.code, 1) << c.message;
    EXPECT_THAT(outcome.error, HasSubstr(c.message));
  }
  EXPECT_FALSE(fs::exists(gone));
}

// CLI11 takes a leading 0 for octal.
TEST_F(CommandUsage, LeadingZerosAreDecimal) {
  const fs::path recording = render("mono", 12);
  ASSERT_EQ(covis({"check", recording, "--count", "010", "--json", "--out", folder / "c.png"}).code, 0);
  EXPECT_EQ(json::parse(text_of(folder / "stdout"), nullptr, false)["frames_read"], 10);
}

// The pictures that Covis leaves beside the images are none of them.
TEST_F(CommandUsage, ItsOwnPicturesAreNoImagesOfTheRecording) {
  const fs::path recording = render("mono", 5);
  for (const fs::path& picture : {recording / "check.png", recording / "images" / "check.png"}) {
    for (int twice = 0; twice < 2; ++twice) {
      const Outcome check = covis({"check", recording, "--json", "--out", picture});
      EXPECT_EQ(check.code, 0) << check.error << check.out;
      EXPECT_EQ(json::parse(check.out, nullptr, false)["frames_read"], 5);
    }
  }
}

TEST_F(CommandUsage, AListThatIsALinkToNothingIsNotTakenForNone) {
  const fs::path recording = render("rgbd", 5), list = recording / "depth.txt";
  fs::remove(list);
  fs::create_symlink("gone.txt", list);
  const Outcome run = covis({"run", recording, "--quiet", "--out", folder / "out"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, HasSubstr("depth.txt: it is a link to what is not there (gone.txt)"));
}

TEST_F(CommandUsage, WhoReadsItsMessagesMayLeave) {
  const fs::path recording = render("rgbd", 10), pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  Process process(command({"run", recording, "--out", folder / "out"}), folder / "stdout", pipe);
  while (!fs::exists(folder / "out") && !process.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  close(reader);
  EXPECT_EQ(process.wait(kPatience), 0);
  expect_results(folder / "out");
}

TEST_F(CommandUsage, HelpAndVersionAreResults) {
  const std::vector<std::string> commands[] = {{"run"},  {"localize"}, {"eval"}, {"check"},
                                               {"view"}, {"synth"},    {"map"},  {"vocab", "train"}};
  for (std::vector<std::string> words : commands) {
    words.push_back("--help");
    const Outcome help = covis(words);
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, HasSubstr("Examples:")) << words[0];
  }
  EXPECT_THAT(covis({"--version"}).out, testing::StartsWith("covis "));
  const Outcome settings = covis({"run", "--dump-config"});
  EXPECT_EQ(settings.code, 0);
  std::ofstream(folder / "settings.yaml") << settings.out;
  EXPECT_EQ(covis({"run", "--dump-config", "--config", folder / "settings.yaml"}).out, settings.out);
}

// The last line says why no frame was tracked, also with --quiet, and `check` lists it.
TEST_F(CommandUsage, ARunWithoutAPoseSaysWhy) {
  const fs::path recording = render("mono", 4);
  const std::string camera = text_of(recording / "camera.yaml");
  const auto with_focal = [&](const std::string& focal) {
    std::string text;
    std::istringstream lines(camera);
    for (std::string line; std::getline(lines, line);)
      text += (line.starts_with("fx:") || line.starts_with("fy:") ? line.substr(0, 3) + " " + focal : line) + "\n";
    std::ofstream(recording / "camera.yaml") << text;
  };
  const std::string out = folder / "out";
  with_focal("1");
  const Outcome wide = covis({"run", recording, "--quiet", "--out", out});
  EXPECT_EQ(wide.code, 1);
  EXPECT_THAT(wide.error, HasSubstr("no frame was tracked: a focal length of 1 pixels"));
  const Outcome check = covis({"check", recording, "--json", "--out", folder / "c.png"});
  EXPECT_EQ(check.code, 1);
  EXPECT_THAT(check.out, HasSubstr("a focal length of 1 pixels"));
  std::ofstream(recording / "camera.yaml") << camera;
  const Outcome few = covis({"run", recording, "--quiet", "--count", "1", "--out", out});
  EXPECT_EQ(few.code, 1);
  EXPECT_THAT(few.error, HasSubstr("no frame was tracked: "));
}

// The name of a file is bytes; JSON is UTF-8.
TEST_F(CommandUsage, PathsNeedNotBeUtf8) {
  const fs::path recording = folder / "caf\xe9", out = folder / "out";
  fs::rename(render("rgbd", 8), recording);
  const Outcome run = covis({"run", recording, "--json", "--camera", recording / "camera.yaml", "--out", out});
  EXPECT_EQ(run.code, 0) << run.error;
  EXPECT_TRUE(json::parse(run.out, nullptr, false).is_object());
  EXPECT_EQ(parsed(out / "summary.json")["frames"], 8);
  EXPECT_EQ(covis({"check", recording, "--json", "--out", folder / "c.png"}).code, 0);
  const Outcome gone = covis({"run", folder / "gon\xe9", "--json", "--out", out});
  EXPECT_THAT(gone.error, HasSubstr("it does not exist"));
}

// A file that would block for ever is refused, whatever it was given as.
TEST_F(CommandUsage, PipesAndDevicesAreNoFiles) {
  const fs::path recording = render("rgbd", 8), pipe = folder / "pipe", out = folder / "out";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"run", recording, "--camera", pipe, "--out", out},
        {"run", recording, "--config", pipe, "--out", out},
        {"run", recording, "--vocabulary", pipe, "--out", out},
        {"run", pipe, "--out", out},
        {"run", "/dev/zero", "--out", out},
        {"eval", pipe, recording / "groundtruth.txt"}}) {
    Process process(command(words), folder / "stdout", folder / "stderr");
    EXPECT_EQ(process.wait(kPatience), 1) << words[2];
    EXPECT_THAT(text_of(folder / "stderr"), HasSubstr("regular file")) << words[2];
  }
  fs::remove(recording / "groundtruth.txt");
  fs::rename(pipe, recording / "groundtruth.txt");
  EXPECT_EQ(covis({"run", recording, "--quiet", "--out", out}).code, 0) << "it does without the truth";
}

// An empty trajectory is not worth an older one.
TEST_F(CommandUsage, ARunWithoutAReadableFrameWritesNothing) {
  const fs::path recording = render("rgbd", 3), out = folder / "out";
  const std::string older =
      "1.000000000 0.000000000 0.000000000 0.000000000 0.000000000 0.000000000 0.000000000 1.000000000\n";
  fs::create_directories(out);
  std::ofstream(out / "trajectory.txt") << older;
  for (const auto& entry : fs::directory_iterator(recording / "depth")) std::ofstream(entry.path()) << "no image";
  const Outcome run = covis({"run", recording, "--quiet", "--out", out});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, HasSubstr("no frame could be read; of the first: " + (recording / "depth").string()));
  EXPECT_EQ(text_of(out / "trajectory.txt"), older);
  EXPECT_FALSE(fs::exists(out / "summary.json"));
}

TEST_F(CommandUsage, AFolderThatCantBeWrittenToIsSaidBeforeTheRun) {
  const fs::path recording = render("rgbd", 3);
  std::ofstream(folder / "file") << "x";
  const Outcome in_file = covis({"run", recording, "--quiet", "--out", folder / "file" / "out"});
  EXPECT_EQ(in_file.code, 1);
  EXPECT_THAT(in_file.error, HasSubstr("the output folder can't be made"));
  if (geteuid() == 0) return;  // root may write anywhere
  fs::create_directories(folder / "locked");
  fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  const Outcome locked = covis({"run", recording, "--quiet", "--out", folder / "locked"});
  EXPECT_EQ(locked.code, 1);
  EXPECT_THAT(locked.error, HasSubstr("can't be written to"));
}

TEST_F(CommandUsage, AFullDiskIsSaidAndTheOtherFilesAreWritten) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  const fs::path recording = render("rgbd", 10);
  for (const std::string& full : kFiles) {
    SCOPED_TRACE(full);
    const fs::path out = folder / ("out_" + full);
    fs::create_directories(out);
    fs::create_symlink("/dev/full", out / full);
    const Outcome run = covis({"run", recording, "--quiet", "--out", out});
    EXPECT_EQ(run.code, 1);
    EXPECT_THAT(run.error, testing::AllOf(HasSubstr(full), HasSubstr("No space left on device")));
    for (const std::string& name : kFiles) {
      if (name == full) continue;
      EXPECT_GT(fs::file_size(out / name), 0u) << name;
    }
  }
  // Results on stdout are no less results.
  const fs::path truth = recording / "groundtruth.txt";
  Process eval(command({"eval", truth, truth}), "/dev/full", folder / "stderr");
  EXPECT_EQ(eval.wait(kPatience), 1);
  EXPECT_THAT(text_of(folder / "stderr"), HasSubstr("stdout"));
  Process help(command({"--help"}), "/dev/full", folder / "stderr");
  EXPECT_EQ(help.wait(kPatience), 1);
}

}  // namespace
}  // namespace covis
