// SPDX-License-Identifier: Apache-2.0
// `covis run --save-map`: what may be replaced, what a kill leaves, and that saving changes nothing.
#include "command_results.h"
#include "covis/storage/map_file.h"

namespace covis {
namespace {

using testing::HasSubstr;

class CommandSave : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    recording = render("rgbd", 30);
    map = folder / "m.covis";
    aside = folder / "m.covis.unfinished";
  }
  std::vector<std::string> run_of(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"run", recording, "--quiet", "--out", folder / "out", "--save-map", map};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  fs::path recording, map, aside;
};

TEST_F(CommandSave, AsideMeanwhileChangesNothing) {
  ASSERT_EQ(covis(run_of({"--save-every", "0"})).code, 0);
  const std::string bytes = text_of(map), trajectory = text_of(folder / "out/trajectory.txt");
  const Outcome run = covis(run_of({"--save-every", "2"}));
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_EQ(text_of(map), bytes);
  EXPECT_EQ(text_of(folder / "out/trajectory.txt"), trajectory);
  EXPECT_FALSE(fs::exists(aside)) << "the run ended well";
  EXPECT_THAT(covis(run_of({"--save-every", "often"})).error, HasSubstr("--save-every often: a number of frames"));
}

TEST_F(CommandSave, WhatAKilledRunLeavesIsAMap) {
  int code = 0;
  for (int tried = 0; tried < 5 && code == 0; ++tried) {  // a machine so busy that the run ends first tries again
    fs::remove(map);
    Process process(command(run_of({"--save-every", "1"})), folder / "stdout", folder / "stderr");
    while (!fs::exists(aside) && !process.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    process.send(SIGKILL);
    code = process.wait(std::chrono::seconds(60));
  }
  ASSERT_EQ(code, 128 + SIGKILL);
  EXPECT_FALSE(fs::exists(map));
  const auto left = storage::load_map(aside);
  ASSERT_TRUE(left) << left.error().message;
  EXPECT_GT(left->map.key_frame_count(), 0u);
  const std::string bytes = text_of(aside);
  const Outcome next = covis(run_of({}));
  EXPECT_EQ(next.code, 0);
  EXPECT_THAT(next.error, HasSubstr("it is the map of a run that did not end well"));
  EXPECT_TRUE(fs::exists(map));
  EXPECT_EQ(text_of(aside), bytes) << "a run that saved nothing aside leaves what it did not write";
  EXPECT_EQ(covis(run_of({"--save-every", "1"})).code, 0);
  EXPECT_FALSE(fs::exists(aside)) << "its own";
  EXPECT_EQ(text_of(folder / "m.covis.unfinished.old"), bytes);
}

TEST_F(CommandSave, TheMapMayGoToTheFolderOfTheResults) {
  const fs::path out = folder / "new" / "out";
  const auto run_to = [&](const fs::path& file) {
    return covis({"run", recording, "--quiet", "--count", "5", "--out", out, "--save-map", file});
  };
  EXPECT_THAT(run_to(folder / "elsewhere/m").error, HasSubstr("elsewhere/m: it can't be written"));
  EXPECT_FALSE(fs::exists(folder / "new")) << "the run has not begun";
  const Outcome run = run_to(out / "m.covis");
  EXPECT_EQ(run.code, 0) << run.error;
  EXPECT_TRUE(storage::load_map(out / "m.covis"));
}

TEST_F(CommandSave, ARunThatTracksNothingLeavesTheOldMap) {
  ASSERT_EQ(covis(run_of({})).code, 0);
  const std::string bytes = text_of(map);
  const Outcome nothing = covis(run_of({"--sensor", "mono", "--count", "1"}));
  EXPECT_EQ(nothing.code, 1);
  EXPECT_THAT(nothing.error, HasSubstr("m.covis: there is no map to save"));
  EXPECT_EQ(text_of(map), bytes);
}

TEST_F(CommandSave, WhatCanNotBeReplacedOrWrittenIsSaidBeforeTheRun) {
  const std::string camera = "%YAML:1.0\n---\nCamera.fx: 500\n";
  std::ofstream(map) << camera;
  const Outcome foreign = covis(run_of({}));
  EXPECT_EQ(foreign.code, 1);
  EXPECT_THAT(foreign.error, HasSubstr("m.covis: it is there and is not a map of Covis"));
  EXPECT_EQ(text_of(map), camera);
  fs::remove(map);
  fs::create_directories(map);
  EXPECT_THAT(covis(run_of({})).error, HasSubstr("m.covis: it can't be written"));
  EXPECT_FALSE(fs::exists(folder / "out")) << "the run has not begun";
}

}  // namespace
}  // namespace covis
