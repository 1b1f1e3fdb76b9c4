// SPDX-License-Identifier: Apache-2.0
// --sandbox: what a process that reads files of strangers can't do any more, and that it still does its work.
#include <sys/socket.h>
#include <sys/stat.h>

#include <functional>
#include <thread>

#include "apps/sandbox.h"
#include "command_results.h"

namespace covis {
namespace {

using testing::HasSubstr;

class CommandSandbox : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    if (const Outcome tried = covis({"--sandbox", folder / "tried", "check", folder / "nothing"});
        tried.error.find("--sandbox: ") != std::string::npos)
      GTEST_SKIP() << tried.error;
    std::ofstream(folder / "outside.txt") << "precious";
  }
};

// Runs `act` in a child within the sandbox; returns whether it returned true.
bool works_inside(const std::string& writable, const std::function<bool()>& act) {
  const pid_t child = fork();
  if (child == 0) std::_Exit(app::enter_sandbox({writable}) ? (act() ? 0 : 1) : 2);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) < 2) << "it is entered";
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST_F(CommandSandbox, WritesIntoItsFoldersAlone) {
  const std::string inside = folder / "inside", outside = folder / "outside.txt";
  const auto writes = [](const std::string& file) { return static_cast<bool>(std::ofstream(file) << "x" << std::flush); };
  EXPECT_TRUE(works_inside(inside, [&] { return writes(inside + "/new.txt") && ::unlink((inside + "/new.txt").c_str()) == 0; }));
  EXPECT_FALSE(works_inside(inside, [&] { return writes(outside); }));
  EXPECT_FALSE(works_inside(inside, [&] { return writes(folder / "new.txt"); }));
  EXPECT_FALSE(works_inside(inside, [&] { return ::unlink(outside.c_str()) == 0; }));
  EXPECT_FALSE(works_inside(inside, [&] { return ::rename(outside.c_str(), (inside + "/taken.txt").c_str()) == 0; }));
  EXPECT_FALSE(works_inside(inside, [&] { return ::mkdir((folder / "made").c_str(), 0777) == 0; }));
  EXPECT_FALSE(works_inside(inside, [&] { return ::symlink(outside.c_str(), (inside + "/link").c_str()) == 0; }));
  EXPECT_TRUE(works_inside(inside, [&] { return text_of(outside) == "precious"; })) << "reading is free";
  EXPECT_EQ(text_of(outside), "precious");
}

TEST_F(CommandSandbox, RunsNothingAndConnectsToNothing) {
  const std::string inside = folder / "inside";
  EXPECT_FALSE(works_inside(inside, [] {
    ::execl("/bin/true", "true", nullptr);
    return errno != EPERM && errno != EACCES;
  }));
  for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK})
    EXPECT_FALSE(works_inside(inside, [&] { return ::socket(family, SOCK_DGRAM, 0) >= 0; })) << family;
  const pid_t parent = ::getpid();
  EXPECT_FALSE(works_inside(inside, [&] { return ::kill(parent, SIGCONT) == 0; }));
  EXPECT_TRUE(works_inside(inside, [&] { return ::kill(parent, 0) == 0; })) << "asking is free";
  EXPECT_TRUE(works_inside(inside, [] {
    bool ran = false;
    std::thread([&] { ran = true; }).join();
    return ran;
  }));
}

TEST_F(CommandSandbox, ARunIsTheSame) {
  const std::string recording = render("rgbd", 30), inside = folder / "inside", map = inside + "/room.m";
  const auto run = [&](std::vector<std::string> words, const std::string& out) {
    words.insert(words.end(), {"run", recording, "--quiet", "--out", out, "--save-map", out + "/room.m"});
    return covis(words);
  };
  ASSERT_EQ(run({}, folder / "free").code, 0);
  ASSERT_EQ(run({"--sandbox", inside}, inside + "/out").code, 0);
  for (const char* file : {"trajectory.txt", "map.ply", "keyframes.txt", "room.m"})
    EXPECT_EQ(text_of(inside + "/out/" + file), text_of(folder / "free" / file)) << file;
  const Outcome elsewhere = covis({"--sandbox", inside, "run", recording, "--quiet", "--out", folder / "free"});
  EXPECT_EQ(elsewhere.code, 1);
  EXPECT_THAT(elsewhere.error, HasSubstr("the output folder can't be written to"));
}

TEST_F(CommandSandbox, AFolderThatCannotBeHadIsNamed) {
  const std::string file = folder / "outside.txt";
  const Outcome outcome = covis({"--sandbox", file, "check", folder / "nothing"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.error, HasSubstr("--sandbox: " + file));
}

}  // namespace
}  // namespace covis
