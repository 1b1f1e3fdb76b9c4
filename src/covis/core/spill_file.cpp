// SPDX-License-Identifier: Apache-2.0
#include "covis/core/spill_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <new>

namespace covis {

namespace {

int open_unnamed() {
  for (const char* folder : {static_cast<const char*>(std::getenv("TMPDIR")), "/var/tmp", "/tmp"}) {
    const int handle = folder ? ::open(folder, O_TMPFILE | O_RDWR | O_EXCL | O_CLOEXEC, 0600) : -1;
    if (handle >= 0) return handle;
  }
  return -1;
}

}  // namespace

SpillFile::~SpillFile() {
  if (handle_ && *handle_ != kNone) ::close(*handle_);
}

SpillFile::Block SpillFile::map(size_t bytes) {
  if (!handle_) handle_ = open_unnamed();
  const auto length = static_cast<off_t>(bytes);
  // Room is taken in advance: a page that the disk has no room for when it is written would end the process.
  if (*handle_ != kNone && ::posix_fallocate(*handle_, size_, length) == 0) {
    void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, *handle_, size_);
    if (memory != MAP_FAILED) {
      size_ += length;
      return {memory, bytes, true};
    }
  }
  return plain(bytes);
}

SpillFile::Block SpillFile::plain(size_t bytes) {
  void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return {memory, bytes, false};
}

void SpillFile::page_out(const Block& block) {
  if (block.in_file) ::madvise(block.memory, block.bytes, MADV_DONTNEED);
}

void SpillFile::unmap(const Block& block) { ::munmap(block.memory, block.bytes); }

}  // namespace covis
