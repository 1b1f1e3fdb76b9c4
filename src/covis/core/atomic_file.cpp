// SPDX-License-Identifier: Apache-2.0
#include "covis/core/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <new>
#include <optional>
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

// Makes a file's bytes, and returns 0 or errno as the functions here do.
using Contents = std::function<int(FileSink&)>;

int write_device(const std::filesystem::path& file, const Contents& contents) {
  std::string bytes;
  FileSink sink(bytes);
  if (const int problem = contents(sink); problem != 0) return problem;
  // Opening a pipe would wait for its reader, perhaps for ever; O_NONBLOCK tells that there is none. Writing may wait.
  const int handle = ::open(file.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
  if (handle < 0) return errno;
  int problem = ::fcntl(handle, F_SETFL, O_WRONLY) == 0 ? write_all(handle, bytes) : errno;
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

constexpr std::string_view kInfix = ".tmp";  // temporary names are TARGET.tmpPID-NUMBER

std::filesystem::path temporary_name(const std::filesystem::path& target) {
  static std::atomic<unsigned> count = 0;
  std::filesystem::path name = target;
  name += std::string(kInfix) + std::to_string(::getpid()) + "-" + std::to_string(count++);
  return name;
}

// Calls make(name) with fresh names beside the target until it does not fail with EEXIST: an existing file or link of
// that name is never written to. Returns its result and leaves the name in `temporary`.
template <class Make>
int with_temporary_name(const std::filesystem::path& target, std::filesystem::path& temporary, Make make) {
  int problem = EEXIST;
  for (int tried = 0; tried < kNames && problem == EEXIST; ++tried) {
    temporary = temporary_name(target);
    problem = make(temporary);
  }
  return problem;
}

// Returns the process in a temporary name of the target; 0: it is no such name.
pid_t process_of(std::string_view name, std::string_view target) {
  if (!name.starts_with(target) || !name.substr(target.size()).starts_with(kInfix)) return 0;
  name.remove_prefix(target.size() + kInfix.size());
  const auto is_number = [](std::string_view text) {
    return !text.empty() && text.size() < 11 && text.find_first_not_of("0123456789") == std::string_view::npos;
  };
  const size_t dash = name.find('-');
  if (dash == std::string_view::npos || !is_number(name.substr(0, dash)) || !is_number(name.substr(dash + 1))) return 0;
  pid_t process = 0;
  const auto read = std::from_chars(name.data(), name.data() + dash, process);
  return read.ec == std::errc() ? process : 0;
}

// A writer holds a lock on its temporary file. It goes with the writer, also when that is in another container, whose
// processes have numbers of their own.
bool is_left_behind(const std::filesystem::path& file) {
  const int handle = ::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (handle < 0) return false;
  struct stat status {};
  const bool left = ::fstat(handle, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
                    ::flock(handle, LOCK_EX | LOCK_NB) == 0;
  ::close(handle);
  return left;
}

int write_contents(int handle, const Contents& contents, Durability durability, const mode_t* mode) {
  FileSink sink(handle);
  int problem = 0;
  try {
    problem = contents(sink);
  } catch (const std::bad_alloc&) {
    problem = ENOMEM;
  }
  // A sandbox does not allow it: there the new file has the permissions of any other.
  if (problem == 0 && mode != nullptr && ::fchmod(handle, *mode) != 0 && errno != EPERM) problem = errno;
  if (problem == 0 && durability == Durability::durable && ::fsync(handle) != 0) problem = errno;
  // A network's file system may say only when a file is closed that it has no room for it. To close a second handle
  // makes it say so now, before the old file is replaced; the first one holds the lock until then.
  if (problem == 0) {
    const int second = ::fcntl(handle, F_DUPFD_CLOEXEC, 0);
    if (second < 0 || ::close(second) != 0) problem = errno;
  }
  return problem;
}

int rename_to(const std::filesystem::path& temporary, const std::filesystem::path& target) {
  if (::rename(temporary.c_str(), target.c_str()) == 0) return 0;
  const int problem = errno;
  ::unlink(temporary.c_str());
  return problem;
}

// A file without a name until it is complete, so that a killed process leaves nothing. It can be given a name that is
// free, but not one that exists: then it gets a temporary one for the moment of a rename. Returns nullopt when the file
// system has no such files.
std::optional<int> write_unnamed(const std::filesystem::path& target, const Contents& contents, Durability durability,
                                 const mode_t* mode) {
  const std::filesystem::path folder = target.parent_path();
  const int handle = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  if (handle < 0) return std::nullopt;
  ::flock(handle, LOCK_EX | LOCK_NB);
  std::optional<int> problem = write_contents(handle, contents, durability, mode);
  if (problem == 0) {
    const std::string own = "/proc/self/fd/" + std::to_string(handle);
    const auto link = [&](const std::filesystem::path& name) {
      return ::linkat(AT_FDCWD, own.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0 ? 0 : errno;
    };
    problem = link(target);
    if (problem == EEXIST) {
      std::filesystem::path temporary;
      problem = with_temporary_name(target, temporary, link);
      if (problem == 0) problem = rename_to(temporary, target);
    } else if (problem != 0) {
      problem = std::nullopt;  // without /proc there is no way to name it
    }
  }
  ::close(handle);
  return problem;
}

int write_named(const std::filesystem::path& target, const Contents& contents, Durability durability,
                const mode_t* mode) {
  std::filesystem::path temporary;
  int handle = -1;
  int problem = with_temporary_name(target, temporary, [&](const std::filesystem::path& name) {
    handle = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    return handle >= 0 ? 0 : errno;
  });
  if (problem != 0) return problem;
  ::flock(handle, LOCK_EX | LOCK_NB);
  problem = write_contents(handle, contents, durability, mode);
  if (problem == 0) {
    problem = rename_to(temporary, target);
  } else {
    ::unlink(temporary.c_str());
  }
  ::close(handle);
  return problem;
}

// mode: the permissions of the file that is replaced; nullptr when there is no such file.
int write_and_rename(const std::filesystem::path& target, const Contents& contents, Durability durability,
                     TemporaryFile temporary, const mode_t* mode) {
  std::optional<int> problem;
  if (temporary == TemporaryFile::unnamed) problem = write_unnamed(target, contents, durability, mode);
  if (!problem) problem = write_named(target, contents, durability, mode);
  if (problem == 0 && durability == Durability::durable) sync_folder(target.parent_path());
  return *problem;
}

// The file that a link leads to; the file itself when it is no link, or leads nowhere.
std::filesystem::path followed(const std::filesystem::path& file, std::error_code& error) {
  if (!std::filesystem::is_symlink(file, error)) return file;
  return std::filesystem::canonical(file, error);
}

int write_file(const std::filesystem::path& file, const Contents& contents, Durability durability,
               TemporaryFile temporary) {
  struct stat status {};
  const bool exists = ::stat(file.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return EISDIR;
  // Renaming over a device would replace it by a regular file.
  if (exists && !S_ISREG(status.st_mode)) return write_device(file, contents);
  std::error_code error;
  const std::filesystem::path target = followed(file, error);
  if (target.empty()) return error.value();
  if (durability == Durability::durable) remove_left_behind(target);
  const mode_t mode = status.st_mode & 0777;
  return write_and_rename(target, contents, durability, temporary, exists ? &mode : nullptr);
}

Result<void> cannot_be_written(const std::filesystem::path& file, int problem) {
  if (problem == ENXIO) return fail(file.string() + ": it can't be written: it is a pipe that nobody reads");
  return fail(file.string() + ": it can't be written: " + std::generic_category().message(problem));
}

}  // namespace

void FileSink::append(std::string_view bytes) {
  if (memory_) {
    memory_->append(bytes);
  } else if (problem_ == 0) {
    problem_ = write_all(handle_, bytes);
  }
}

void FileSink::rewrite(uint64_t at, std::string_view bytes) {
  if (memory_) {
    memory_->replace(at, bytes.size(), bytes);
    return;
  }
  while (problem_ == 0 && !bytes.empty()) {
    const ssize_t n = ::pwrite(handle_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      problem_ = n == 0 ? ENOSPC : errno;
      return;
    }
    bytes.remove_prefix(static_cast<size_t>(n));
    at += static_cast<uint64_t>(n);
  }
}

Result<void> write_atomically(const std::filesystem::path& file, std::string_view bytes, Durability durability,
                              TemporaryFile temporary) {
  const auto write = [&](FileSink& sink) -> Result<void> {
    sink.append(bytes);
    return {};
  };
  return write_atomically(file, write, durability, temporary);
}

Result<void> write_atomically(const std::filesystem::path& file, const std::function<Result<void>(FileSink&)>& write,
                              Durability durability, TemporaryFile temporary) {
  Result<void> refused;
  const auto contents = [&](FileSink& sink) {
    refused = write(sink);
    return refused ? sink.problem() : ECANCELED;
  };
  const int problem = write_file(file, contents, durability, temporary);
  if (problem == 0) return {};
  return refused ? cannot_be_written(file, problem) : refused;
}

Result<void> check_writable(const std::filesystem::path& file) {
  const auto refused = [&](int problem) { return cannot_be_written(file, problem); };
  struct stat status {};
  const bool exists = ::stat(file.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return refused(EISDIR);
  if (exists && !S_ISREG(status.st_mode)) return {};  // a device takes it or not
  std::error_code error;
  const std::filesystem::path target = followed(file, error);
  if (target.empty()) return refused(error.value());
  remove_left_behind(target);
  std::filesystem::path temporary;
  const int problem = with_temporary_name(target, temporary, [](const std::filesystem::path& name) {
    const int handle = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (handle < 0) return errno;
    ::close(handle);
    return 0;
  });
  if (problem != 0) return refused(problem);
  ::unlink(temporary.c_str());
  return {};
}

void remove_left_behind(const std::filesystem::path& target) {
  std::error_code error;
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
  const std::string name = target.filename().string();
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const pid_t process = process_of(entry->path().filename().string(), name);
    if (process <= 0 || ::kill(process, 0) == 0 || errno != ESRCH) continue;
    if (is_left_behind(entry->path())) ::unlink(entry->path().c_str());
  }
}

}  // namespace covis
