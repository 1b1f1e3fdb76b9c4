// SPDX-License-Identifier: Apache-2.0
// Files that are written completely or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "covis/core/error.h"

namespace covis {

// durable: the bytes and the name are on disk when the call returns, so that even after a power failure either the old
// or the new file is there, complete. Waiting for the disk takes time. fast: the same guarantee as long as the
// operating system keeps running, even if the process is killed.
enum class Durability { fast, durable };

// unnamed: the temporary file has no name until it is complete, where the file system has such files (elsewhere it is
// named). named: it is TARGET.tmpPID-NUMBER all the time, and a process that is killed leaves it behind.
enum class TemporaryFile { unnamed, named };

// Writes to a temporary file in the same folder and renames it. On an error (a full disk, no write permission) the old
// file is unchanged and no temporary file is left. A killed process leaves one only if that happens between two system
// calls, or where files cannot be unnamed; the next durable writing of the same file removes it. A symbolic link is
// kept and its target replaced; a link without a target is an error. A replaced file keeps its permissions. A pipe or a
// device is written to directly. Threads and processes may write the same file at once: one of them wins.
Result<void> write_atomically(const std::filesystem::path& file, std::string_view bytes,
                              Durability durability = Durability::fast,
                              TemporaryFile temporary = TemporaryFile::unnamed);

// Takes the bytes of a file piece by piece, to an open file or to memory. After an error it writes nothing more.
class FileSink {
 public:
  explicit FileSink(int handle) : handle_(handle) {}
  explicit FileSink(std::string& memory) : memory_(&memory) {}
  void append(std::string_view bytes);
  // Writes over bytes that were appended.
  void rewrite(uint64_t at, std::string_view bytes);
  int problem() const { return problem_; }  // errno; 0: none so far

 private:
  int handle_ = -1;
  std::string* memory_ = nullptr;
  int problem_ = 0;
};

// The same for a file too large to be held in memory: `write` makes its bytes. It may be called again, on file systems
// without unnamed files. When it returns an error, that is returned, and the old file is unchanged. (What goes to a
// pipe or a device is held in memory all the same.)
Result<void> write_atomically(const std::filesystem::path& file, const std::function<Result<void>(FileSink&)>& write,
                              Durability durability = Durability::fast,
                              TemporaryFile temporary = TemporaryFile::unnamed);

// Tries whether the file could be written now, by making an empty one beside it and removing that again.
Result<void> check_writable(const std::filesystem::path& file);

// Removes what processes that are gone left beside the file while they wrote it: regular files of this user with names
// of ours, that no process holds.
void remove_left_behind(const std::filesystem::path& file);

}  // namespace covis
