// SPDX-License-Identifier: Apache-2.0
#include "covis/core/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace covis {
namespace {

tl::unexpected<Error> fail_errno(const std::filesystem::path& file, const char* what) {
  return fail(file.string() + ": " + what + ": " + std::generic_category().message(errno));
}

struct FileHandle {  // closes the file descriptor on destruction
  int fd;
  ~FileHandle() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

Result<std::unique_ptr<MappedFile>> MappedFile::open(const std::filesystem::path& file) {
  // Without waiting: a pipe that nobody writes to would be waited for, and is no file anyway.
  const FileHandle handle{::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (handle.fd < 0) return fail_errno(file, "can't be opened");
  struct stat status {};
  if (::fstat(handle.fd, &status) != 0) return fail_errno(file, "can't be read");
  if (!S_ISREG(status.st_mode)) return fail(file.string() + ": it is not a regular file");
  std::unique_ptr<MappedFile> mapped(new MappedFile);
  if (status.st_size == 0) return mapped;  // an empty range cannot be mapped
  const auto size = static_cast<size_t>(status.st_size);
  void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, handle.fd, 0);
  if (data == MAP_FAILED) return fail_errno(file, "can't be mapped");
  mapped->data_ = static_cast<const std::byte*>(data);
  mapped->size_ = size;
  return mapped;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

}  // namespace covis
