// SPDX-License-Identifier: Apache-2.0
// For tests: the covis command as users run it, in a process of its own.
#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "apps/command.h"

namespace covis {

namespace fs = std::filesystem;

inline std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// A child process: the covis command, or another program. It ends with its owner.
class Process {
 public:
  // one_core: run it on the first core that this process may use, like `taskset`.
  Process(const std::vector<std::string>& command, const fs::path& standard_out, const fs::path& standard_error,
          bool one_core = false) {
    std::fflush(nullptr);  // else the child would write it too
    id_ = fork();
    if (id_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (id_ > 0) return;
    redirect(standard_out, STDOUT_FILENO);
    redirect(standard_error, STDERR_FILENO);
    if (one_core) keep_one_core();
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    // Called instead of executed: to load the libraries of OpenCV takes longer than most cases.
    if (command.front() == COVIS_COMMAND) {
      cv::setNumThreads(-1);
      std::exit(covis_command(static_cast<int>(command.size()), arguments.data()));
    }
    execv(arguments[0], arguments.data());
    std::_Exit(127);
  }
  ~Process() {
    if (id_ <= 0) return;
    ::kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  // Sends nothing after the process ended: an id of 0 or -1 would address every process of the group or of the user.
  void send(int signal) const {
    if (id_ > 0) ::kill(id_, signal);
  }
  bool ended() {
    if (id_ > 0 && waitpid(id_, &status_, WNOHANG) == id_) id_ = 0;
    return id_ <= 0;
  }
  // Returns the exit code, 128 plus the number of the signal that ended the process, or -1 if it still runs after
  // `limit`.
  int wait(std::chrono::duration<double> limit) {
    const auto until = std::chrono::steady_clock::now() + limit;
    while (!ended()) {
      if (std::chrono::steady_clock::now() > until) return -1;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return WIFSIGNALED(status_) ? 128 + WTERMSIG(status_) : WEXITSTATUS(status_);
  }

 private:
  static void redirect(const fs::path& file, int descriptor) {
    const int opened = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (opened < 0 || dup2(opened, descriptor) < 0) std::_Exit(127);
    close(opened);
  }
  static void keep_one_core() {
    cpu_set_t allowed, one;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof allowed, &allowed);
    int core = 0;
    while (core < CPU_SETSIZE - 1 && !CPU_ISSET(core, &allowed)) ++core;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    if (sched_setaffinity(0, sizeof one, &one) != 0) std::_Exit(127);
  }

  pid_t id_ = -1;
  int status_ = 0;
};

struct Outcome {
  int code = 0;
  std::string out, error;  // output on stdout and stderr
};

// Each test case has a folder of its own.
class CommandTest : public testing::Test {
 protected:
  // Enough for a run under the thread sanitizer on a busy machine.
  static constexpr std::chrono::seconds kPatience{240};

  void SetUp() override {
    const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::path(testing::TempDir()) /
             ("covis_" + std::string(test.test_suite_name()) + "_" + test.name() + "_" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder);
    cv::setNumThreads(0);  // a forked child would miss OpenCV's threads
  }
  void TearDown() override { fs::remove_all(folder); }

  static std::vector<std::string> command(std::vector<std::string> words) {
    words.insert(words.begin(), COVIS_COMMAND);
    return words;
  }
  Outcome covis(const std::vector<std::string>& words, bool one_core = false) const {
    Process process(command(words), folder / "stdout", folder / "stderr", one_core);
    const int code = process.wait(kPatience);
    return {code, text_of(folder / "stdout"), text_of(folder / "stderr")};
  }
  // Renders a recording in the case's folder.
  fs::path render(const std::string& sensor, int frames, const std::string& world = "desk") const {
    const fs::path recording = folder / (world + "_" + sensor);
    const Outcome made = covis({"synth", world, "--sensor", sensor, "--frames", std::to_string(frames), "--width",
                                "320", "--height", "240", "--quiet", "--out", recording});
    EXPECT_EQ(made.code, 0) << made.error;
    return recording;
  }

  fs::path folder;
};

}  // namespace covis
