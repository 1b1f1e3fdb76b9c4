// SPDX-License-Identifier: Apache-2.0
// A temporary file without a name that takes what a long run seldom needs: its blocks are memory that is mapped from
// the file, so that their pages need not stay resident. The file is in $TMPDIR, else in /var/tmp or /tmp, and is gone
// when its blocks are unmapped or the process ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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
  SpillFile(SpillFile&& other) noexcept : handle_(std::exchange(other.handle_, kNone)), size_(other.size_) {}
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
  static constexpr int kNone = -1;

  std::optional<int> handle_;  // kNone: no file can be made; nullopt: it was not tried yet
  int64_t size_ = 0;
};

}  // namespace covis
