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

// Runs `act` in a child; true when it returned true there.
bool works(const std::function<bool()>& act) {
  const pid_t child = fork();
  if (child == 0) std::_Exit(act() ? 0 : 1);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// The same within the sandbox.
bool works_inside(const std::string& writable, const std::function<bool()>& act) {
  return works([&] {
    if (!app::enter_sandbox({writable})) std::_Exit(2);
    return act();
  });
}

// Expects that a call returns 0 outside the sandbox, where this system has it at all, and does not inside.
void expect_refused(const char* name, const std::string& writable, const std::function<long()>& call) {
  const auto succeeds = [&] { return call() == 0; };
  if (!works(succeeds)) {
    std::printf("%s: it does not work here anyway\n", name);
    return;
  }
  EXPECT_TRUE(works_inside(writable, [] { return true; })) << name;
  EXPECT_FALSE(works_inside(writable, succeeds)) << name;
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
  expect_refused("execl", inside, [] { return ::execl("/bin/true", "true", nullptr); });
  for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK})
    expect_refused("socket", inside, [&] { return ::socket(family, SOCK_DGRAM, 0) < 0; });
  EXPECT_TRUE(works_inside(inside, [] {
    bool ran = false;
    std::thread([&] { ran = true; }).join();
    return ran;
  }));
}

TEST_F(CommandSandbox, TouchesNoOtherProcess) {
  const std::string inside = folder / "inside";
  const pid_t parent = ::getpid();
  expect_refused("kill", inside, [&] { return ::kill(parent, SIGCONT); });
  expect_refused("tkill", inside, [&] { return ::syscall(SYS_tkill, parent, SIGCONT); });
  expect_refused("tgkill", inside, [&] { return ::syscall(SYS_tgkill, parent, parent, SIGCONT); });
  expect_refused("rt_sigqueueinfo", inside, [&] {
    siginfo_t info{};
    info.si_code = SI_QUEUE;
    return ::syscall(SYS_rt_sigqueueinfo, parent, SIGCONT, &info);
  });
  const int weight = ::getpriority(PRIO_PROCESS, 0);
  expect_refused("setpriority", inside, [&] { return ::setpriority(PRIO_PROCESS, static_cast<id_t>(parent), weight); });
  expect_refused("prlimit", inside, [&] {
    rlimit limit{};
    return ::prlimit(parent, RLIMIT_CORE, nullptr, &limit);
  });
  expect_refused("shmget", inside, [&] {
    const int segment = ::shmget(IPC_PRIVATE, 4096, 0600);
    return segment < 0 ? -1 : ::shmctl(segment, IPC_RMID, nullptr);
  });
  expect_refused("clone", inside,
                 [&] { return ::syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, nullptr, nullptr, nullptr, 0) < 0; });
  EXPECT_TRUE(works_inside(inside, [&] { return ::kill(parent, 0) == 0; })) << "asking is free";
  EXPECT_TRUE(works_inside(inside, [] { return ::setpriority(PRIO_PROCESS, 0, 19) == 0; })) << "its own weight";
}

TEST_F(CommandSandbox, LeavesPermissionsAndTimes) {
  const std::string inside = folder / "inside", outside = folder / "outside.txt";
  const char* const file = outside.c_str();
  expect_refused("chmod", inside, [&] { return ::chmod(file, 0644); });
  expect_refused("fchmod", inside, [&] { return ::fchmod(::open(file, O_RDONLY | O_CLOEXEC), 0644); });
  expect_refused("chown", inside, [&] { return ::chown(file, ::getuid(), ::getgid()); });
  expect_refused("utimensat", inside, [&] { return ::utimensat(AT_FDCWD, file, nullptr, 0); });
  expect_refused("setxattr", inside, [&] { return ::setxattr(file, "user.covis", "x", 1, 0); });
  expect_refused("truncate", inside, [&] { return ::truncate(file, 8); });  // its size already
  EXPECT_FALSE(works_inside(inside, [&] { return ::open(file, O_RDONLY | O_TRUNC | O_CLOEXEC) >= 0; }));
  EXPECT_EQ(text_of(outside), "precious");
}

// Text that is pushed into the terminal would be typed into the shell that reads it next.
TEST_F(CommandSandbox, TypesNothingIntoItsTerminal) {
  expect_refused("TIOCSTI", folder / "inside", [] {
    const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0) return -1;
    const int shell = ::open(::ptsname(terminal), O_RDWR | O_NOCTTY | O_CLOEXEC);
    char typed = 'x';
    return ::setsid() < 0 || ::ioctl(shell, TIOCSCTTY, 0) != 0 ? -1 : ::ioctl(shell, TIOCSTI, &typed);
  });
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
