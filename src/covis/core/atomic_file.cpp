// SPDX-License-Identifier: Apache-2.0
#include "covis/core/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>

namespace covis {
namespace {

// Number of temporary names tried. A name is in use only if a killed process with our id left it behind.
constexpr int kNames = 1000;

// All functions return 0 or errno.
int write_all(int handle, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(handle, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n == 0 ? ENOSPC : errno;
    bytes.remove_prefix(static_cast<size_t>(n));
  }
  return 0;
}

int write_device(const std::filesystem::path& file, std::string_view bytes) {
  const int handle = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (handle < 0) return errno;
  int problem = write_all(handle, bytes);
  if (::close(handle) != 0 && problem == 0) problem = errno;
  return problem;
}

// Some file systems cannot sync a folder. The file is complete all the same, so failures are not reported.
void sync_folder(const std::filesystem::path& folder) {
  const int handle = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return;
  ::fsync(handle);
  ::close(handle);
}

// Opens a new file beside `target`. O_EXCL makes sure that an existing file or link of that name is never written to.
int open_temporary(const std::filesystem::path& target, std::filesystem::path& temporary, int& handle) {
  static std::atomic<unsigned> count = 0;
  for (int tried = 0; tried < kNames; ++tried) {
    temporary = target;
    temporary += ".tmp" + std::to_string(::getpid()) + "-" + std::to_string(count++);
    handle = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (handle >= 0) return 0;
    if (errno != EEXIST) return errno;
  }
  return EEXIST;
}

// mode: the permissions of the file that is replaced; nullptr when there is no such file.
int write_and_rename(const std::filesystem::path& target, std::string_view bytes, Durability durability,
                     const mode_t* mode) {
  std::filesystem::path temporary;
  int handle = -1;
  if (const int problem = open_temporary(target, temporary, handle); problem != 0) return problem;
  int problem = write_all(handle, bytes);
  if (problem == 0 && mode != nullptr && ::fchmod(handle, *mode) != 0) problem = errno;
  if (problem == 0 && durability == Durability::durable && ::fsync(handle) != 0) problem = errno;
  if (::close(handle) != 0 && problem == 0) problem = errno;
  if (problem == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) problem = errno;
  if (problem != 0) ::unlink(temporary.c_str());
  if (problem == 0 && durability == Durability::durable) sync_folder(target.parent_path());
  return problem;
}

int write_file(const std::filesystem::path& file, std::string_view bytes, Durability durability) {
  struct stat status {};
  const bool exists = ::stat(file.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return EISDIR;
  // Renaming over a device would replace it by a regular file.
  if (exists && !S_ISREG(status.st_mode)) return write_device(file, bytes);
  std::error_code error;
  std::filesystem::path target = file;
  if (std::filesystem::is_symlink(file, error)) {
    target = std::filesystem::canonical(file, error);
    if (error) return error.value();
  }
  const mode_t mode = status.st_mode & 0777;
  return write_and_rename(target, bytes, durability, exists ? &mode : nullptr);
}

}  // namespace

Result<void> write_atomically(const std::filesystem::path& file, std::string_view bytes, Durability durability) {
  const int problem = write_file(file, bytes, durability);
  if (problem == 0) return {};
  return fail(file.string() + ": it can't be written: " + std::generic_category().message(problem));
}

}  // namespace covis
