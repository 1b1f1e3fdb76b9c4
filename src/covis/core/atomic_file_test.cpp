// SPDX-License-Identifier: Apache-2.0
// Writing: whole or not at all, whatever stands in the way, and nothing left behind.
#include "covis/core/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <thread>
#include <vector>

#include "covis/core/test_folder.h"

namespace covis {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class AtomicFile : public testing::Test {
 protected:
  auto files() const { return std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()); }
  std::string problem(const fs::path& file, std::string_view bytes) const {
    const auto written = write_atomically(file, bytes);
    return written ? "" : written.error().message;
  }
  const TemporaryFolder folder;
};

TEST_F(AtomicFile, HoldsTheBytesAndNothingIsLeftBeside) {
  const std::string bytes("a\0b\n", 4);
  for (const Durability durability : {Durability::fast, Durability::durable}) {
    ASSERT_TRUE(write_atomically(folder / "out", bytes, durability));
    EXPECT_EQ(read_file(folder / "out"), bytes);
    ASSERT_TRUE(write_atomically(folder / "out", "", durability));
    EXPECT_EQ(read_file(folder / "out"), "");
    EXPECT_EQ(files(), 1);
  }
}

// A pipe without a reader would hold the writer up for ever.
TEST_F(AtomicFile, APipeIsWrittenToIfSomebodyReads) {
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(problem(folder / "pipe", "abc"),
              AllOf(HasSubstr("pipe: it can't be written"), HasSubstr("nobody reads")));
  const int reader = open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  EXPECT_EQ(problem(folder / "pipe", "abc"), "");
  char bytes[4] = {};
  EXPECT_EQ(read(reader, bytes, sizeof bytes), 3);
  EXPECT_STREQ(bytes, "abc");
  close(reader);
}

TEST_F(AtomicFile, IsMadeOfPieces) {
  const auto write = [](FileSink& sink) -> Result<void> {
    for (const char* piece : {"....", "cd", "efgh"}) sink.append(piece);
    sink.rewrite(1, "ab");
    return {};
  };
  for (const TemporaryFile temporary : {TemporaryFile::unnamed, TemporaryFile::named}) {
    ASSERT_TRUE(write_atomically(folder / "out", write, Durability::durable, temporary));
    EXPECT_EQ(read_file(folder / "out"), ".ab.cdefgh");
  }
  EXPECT_EQ(files(), 1);
  std::string memory;
  FileSink sink(memory);
  ASSERT_TRUE(write(sink));
  EXPECT_EQ(memory, ".ab.cdefgh");
}

TEST_F(AtomicFile, PiecesThatCannotBeMadeLeaveTheOldFile) {
  ASSERT_TRUE(write_atomically(folder / "out", "old"));
  const auto write = [](FileSink& sink) -> Result<void> {
    sink.append("new");
    return fail("there is no more");
  };
  for (const TemporaryFile temporary : {TemporaryFile::unnamed, TemporaryFile::named}) {
    const auto written = write_atomically(folder / "out", write, Durability::fast, temporary);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().message, "there is no more");
    EXPECT_EQ(read_file(folder / "out"), "old");
    EXPECT_EQ(files(), 1);
  }
}

TEST_F(AtomicFile, FullDiskLeavesTheOldFile) {
  ASSERT_TRUE(write_atomically(folder / "out", "old"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 1000;
  setrlimit(RLIMIT_FSIZE, &small);
  const auto written = write_atomically(folder / "out", std::string(5000, 'x'), Durability::durable);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, AllOf(HasSubstr("out"), HasSubstr("can't be written")));
  EXPECT_EQ(read_file(folder / "out"), "old");
  EXPECT_EQ(files(), 1) << "a temporary file is left";
}

TEST_F(AtomicFile, WhatCanNotBeWrittenIsAnError) {
  EXPECT_THAT(problem(folder / "no/out", "x"), HasSubstr("no/out: it can't be written"));
  fs::create_directories(folder / "inner");
  EXPECT_THAT(problem(folder / "inner", "x"), HasSubstr("directory"));
  fs::create_symlink("nowhere", folder / "link");
  EXPECT_THAT(problem(folder / "link", "x"), HasSubstr("link"));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(files(), 2);
}

TEST_F(AtomicFile, DevicesAreWrittenTo) {
  // By links, so that a mistake would take their place and not the device's.
  fs::create_symlink("/dev/full", folder / "full");
  EXPECT_THAT(problem(folder / "full", "x"), AllOf(HasSubstr("full"), HasSubstr("No space left")));
  EXPECT_TRUE(fs::is_character_file(folder / "full"));
  fs::create_symlink("/dev/null", folder / "null");
  EXPECT_EQ(problem(folder / "null", "x"), "");
  EXPECT_TRUE(fs::is_character_file(folder / "null"));
}

TEST_F(AtomicFile, LinksStayAndTheirTargetsAreReplaced) {
  fs::create_directories(folder / "inner");
  write_file(folder / "inner/target", "old");
  fs::create_symlink("inner/target", folder / "link");
  EXPECT_EQ(problem(folder / "link", "new"), "");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_file(folder / "inner/target"), "new");
}

TEST_F(AtomicFile, PermissionsOfTheOldFileStay) {
  write_file(folder / "out", "old");
  const auto owner = fs::perms::owner_read | fs::perms::owner_write;
  fs::permissions(folder / "out", owner);
  EXPECT_EQ(problem(folder / "out", "new"), "");
  EXPECT_EQ(fs::status(folder / "out").permissions(), owner);
  const mode_t mask = ::umask(027);
  EXPECT_EQ(problem(folder / "fresh", "new"), "");
  ::umask(mask);
  EXPECT_EQ(fs::status(folder / "fresh").permissions(), owner | fs::perms::group_read);
}

// A link laid where the temporary file will be must not lead the bytes elsewhere.
TEST_F(AtomicFile, NothingThatLiesThereIsWrittenThrough) {
  write_file(folder / "precious", "kept");
  const std::string stem = "out.tmp" + std::to_string(::getpid()) + "-";
  for (int i = 0; i < 200; ++i) fs::create_symlink("precious", folder / (stem + std::to_string(i)));
  EXPECT_EQ(problem(folder / "out", "new"), "");
  EXPECT_EQ(read_file(folder / "precious"), "kept");
  EXPECT_EQ(read_file(folder / "out"), "new");
  EXPECT_FALSE(fs::is_symlink(folder / "out"));
}

TEST_F(AtomicFile, NamedTemporaryFilesDoTheSame) {
  write_file(folder / "out", "old");
  ASSERT_TRUE(write_atomically(folder / "out", "new", Durability::durable, TemporaryFile::named));
  EXPECT_EQ(read_file(folder / "out"), "new");
  EXPECT_EQ(files(), 1);
  fs::create_directories(folder / "full");
  EXPECT_FALSE(write_atomically(folder / "full", "x", Durability::fast, TemporaryFile::named));
}

// A number that no process has: those of Linux end at 4194304.
constexpr const char* kGone = "out.tmp4999999-0";

TEST_F(AtomicFile, WhatADeadProcessLeftIsRemovedByTheNextDurableWriting) {
  write_file(folder / kGone, "half");
  ASSERT_TRUE(write_atomically(folder / "out", "x"));
  EXPECT_TRUE(fs::exists(folder / kGone)) << "a folder is not walked for every fast writing";
  ASSERT_TRUE(write_atomically(folder / "out", "x", Durability::durable));
  EXPECT_FALSE(fs::exists(folder / kGone));
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFile, NothingElseIsRemoved) {
  const std::string living = "out.tmp" + std::to_string(::getppid()) + "-0";
  const std::vector<std::string> others{living,
                                        "out.tmp4999999",
                                        "out.tmp4999999-",
                                        "out.tmp-1",
                                        "out.tmp4999999-0.bak",
                                        "out.tmp4999999-x",
                                        "other.tmp4999999-0",
                                        "out.tmp99999999999999999999-0"};
  for (const std::string& name : others) write_file(folder / name, "kept");
  write_file(folder / "precious", "kept");
  fs::create_symlink("precious", folder / kGone);
  fs::create_directories(folder / "out.tmp4999999-1");
  const auto before = files();
  remove_left_behind(folder / "out");
  EXPECT_EQ(files(), before);
  EXPECT_EQ(read_file(folder / "precious"), "kept");
}

TEST_F(AtomicFile, AFileThatIsBeingWrittenElsewhereStays) {
  write_file(folder / kGone, "half");
  const int handle = ::open((folder / kGone).c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(::flock(handle, LOCK_EX), 0);  // as its writer does, whose number means nothing here
  remove_left_behind(folder / "out");
  EXPECT_TRUE(fs::exists(folder / kGone));
  ::close(handle);
  remove_left_behind(folder / "out");
  EXPECT_FALSE(fs::exists(folder / kGone));
}

TEST_F(AtomicFile, WhetherAFileCanBeWrittenIsKnownBefore) {
  write_file(folder / "out", "old");
  EXPECT_TRUE(check_writable(folder / "out"));
  EXPECT_TRUE(check_writable(folder / "fresh"));
  EXPECT_TRUE(check_writable("/dev/null"));
  EXPECT_EQ(read_file(folder / "out"), "old");
  EXPECT_EQ(files(), 1) << "nothing is left";
  EXPECT_THAT(check_writable(folder / "no/out").error().message, HasSubstr("no/out: it can't be written: No such"));
  EXPECT_THAT(check_writable(folder.path()).error().message, HasSubstr("directory"));
}

TEST_F(AtomicFile, ThreadsThatWriteTheSameFileLeaveOneOfTheirs) {
  constexpr size_t kBytes = 100'000;
  std::vector<std::thread> threads;
  for (const char letter : {'a', 'b', 'c'}) {
    threads.emplace_back([&, letter] {
      for (int k = 0; k < 10; ++k) EXPECT_TRUE(write_atomically(folder / "out", std::string(kBytes, letter)));
    });
  }
  for (std::thread& thread : threads) thread.join();
  const std::string left = read_file(folder / "out");
  EXPECT_EQ(left, std::string(kBytes, left.front()));
  EXPECT_EQ(files(), 1);
}

}  // namespace
}  // namespace covis
