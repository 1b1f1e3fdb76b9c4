// SPDX-License-Identifier: Apache-2.0
// --sandbox: what a process that reads files of strangers can't do any more, and that it still does its work.
#include <sys/ioctl.h>
#include <sys/ipc.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/xattr.h>

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
  const auto writes = [](const std::string& file) { return bool(std::ofstream(file) << "x" << std::flush); };
  const std::string made = inside + "/new.txt";
  EXPECT_TRUE(works_inside(inside, [&] { return writes(made) && ::unlink(made.c_str()) == 0; }));
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
  EXPECT_TRUE(works_inside(inside, [] {
    bool ran = false;
    std::thread([&] { ran = true; }).join();
    return ran;
  }));
}

// True when a call that returns 0 outside the sandbox does not inside.
bool is_refused(const std::string& writable, const std::function<long()>& call) {
  return !works_inside(writable, [&] { return call() == 0; });
}

TEST_F(CommandSandbox, TouchesNoOtherProcess) {
  const std::string inside = folder / "inside";
  const pid_t parent = ::getpid();
  const auto fails = [&](const std::function<long()>& call) { return is_refused(inside, call); };
  EXPECT_TRUE(fails([&] { return ::kill(parent, SIGCONT); }));
  EXPECT_TRUE(fails([&] { return ::syscall(SYS_tkill, parent, SIGCONT); }));
  EXPECT_TRUE(fails([&] { return ::syscall(SYS_tgkill, parent, parent, SIGCONT); }));
  EXPECT_TRUE(fails([&] {
    siginfo_t info{};
    info.si_code = SI_QUEUE;
    return ::syscall(SYS_rt_sigqueueinfo, parent, SIGCONT, &info);
  }));
  const int weight = ::getpriority(PRIO_PROCESS, 0);
  EXPECT_TRUE(fails([&] { return ::setpriority(PRIO_PROCESS, static_cast<id_t>(parent), weight); }));
  EXPECT_TRUE(fails([&] {
    rlimit limit{};
    return ::prlimit(parent, RLIMIT_CORE, nullptr, &limit);
  }));
  EXPECT_TRUE(fails([&] { return ::shmget(IPC_PRIVATE, 4096, 0600) < 0; }));
  EXPECT_TRUE(fails([&] { return ::syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, nullptr, nullptr, nullptr, 0) < 0; }));
  EXPECT_TRUE(works_inside(inside, [&] { return ::kill(parent, 0) == 0; })) << "asking is free";
  EXPECT_TRUE(works_inside(inside, [] { return ::setpriority(PRIO_PROCESS, 0, 19) == 0; })) << "its own weight";
}

TEST_F(CommandSandbox, LeavesPermissionsAndTimes) {
  const std::string inside = folder / "inside", outside = folder / "outside.txt";
  const auto fails = [&](const std::function<long()>& call) { return is_refused(inside, call); };
  EXPECT_TRUE(fails([&] { return ::chmod(outside.c_str(), 0777); }));
  EXPECT_TRUE(fails([&] { return ::fchmod(::open(outside.c_str(), O_RDONLY | O_CLOEXEC), 0777); }));
  EXPECT_TRUE(fails([&] { return ::chown(outside.c_str(), ::getuid(), ::getgid()); }));
  EXPECT_TRUE(fails([&] { return ::utimensat(AT_FDCWD, outside.c_str(), nullptr, 0); }));
  EXPECT_TRUE(fails([&] { return ::setxattr(outside.c_str(), "user.covis", "x", 1, 0); }));
  EXPECT_TRUE(fails([&] { return ::truncate(outside.c_str(), 0); }));
  EXPECT_TRUE(fails([&] { return ::open(outside.c_str(), O_RDONLY | O_TRUNC | O_CLOEXEC) < 0; }));
  EXPECT_EQ(text_of(outside), "precious");
}

// What is pushed into the terminal would be typed into the shell that reads it next.
TEST_F(CommandSandbox, TypesNothingIntoItsTerminal) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0) GTEST_SKIP() << "no terminal to be had";
  const int shell = ::open(::ptsname(terminal), O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(shell, 0);
  EXPECT_FALSE(works_inside(folder / "inside", [&] {
    ::setsid();
    ::ioctl(shell, TIOCSCTTY, 0);
    char typed = 'x';
    return ::ioctl(shell, TIOCSTI, &typed) == 0;
  }));
  ::close(shell);
  ::close(terminal);
}

TEST_F(CommandSandbox, IsNotEnteredBesideOtherThreads) {
  const pid_t child = fork();
  if (child == 0) {
    std::jthread other([](const std::stop_token& stop) {
      while (!stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
    std::_Exit(app::enter_sandbox({(folder / "inside").string()}) ? 1 : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST_F(CommandSandbox, ARunIsTheSame) {
  const std::string recording = render("rgbd", 30), inside = folder / "inside", map = inside + "/room.m";
  const auto run = [&](std::vector<std::string> words, const std::string& out) {
    words.insert(words.end(), {"run", recording, "--quiet", "--out", out, "--save-map", out + "/room.m"});
    return covis(words);
  };
  ASSERT_EQ(run({}, folder / "free").code, 0);
  ASSERT_EQ(run({"--sandbox", inside}, inside + "/out").code, 0);
  // Over what is there: files are replaced, though their permissions can't be set.
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
