// SPDX-License-Identifier: Apache-2.0
// A temporary file without a name that takes what a long run seldom needs: its blocks are memory that is mapped from
// the file, so that their pages need not stay resident. The file is in $TMPDIR, else in /var/tmp or /tmp, and is gone
// when its blocks are unmapped or the process ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

namespace covis {

class SpillFile {
 public:
  struct Block {
    void* memory = nullptr;
    size_t bytes = 0;
    bool in_file = false;  // else it is plain memory
  };

  SpillFile() = default;
  explicit SpillFile(const char* folder) : folder_(folder) {}  // instead of those above
  SpillFile(SpillFile&& other) noexcept
      : folder_(other.folder_), handle_(std::exchange(other.handle_, -1)), tried_(other.tried_), size_(other.size_) {}
  SpillFile& operator=(SpillFile&&) = delete;
  ~SpillFile();

  // Zeroed memory of so many bytes, a multiple of 4096. Plain memory where no file can be made or the disk is full.
  // Throws std::bad_alloc.
  Block map(size_t bytes);
  // Plain memory, zeroed.
  static Block plain(size_t bytes);
  // Lets its pages go from this process's memory; they come back when they are read. Nothing for plain memory.
  static void page_out(const Block& block);
  static void unmap(const Block& block);

 private:
  int open_file() const;

  const char* const folder_ = nullptr;
  int handle_ = -1;  // -1: not opened yet, or none can be had
  bool tried_ = false;
  int64_t size_ = 0;
};

}  // namespace covis
