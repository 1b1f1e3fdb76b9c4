// SPDX-License-Identifier: Apache-2.0
#include "scratch.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <system_error>

#include "target.h"

namespace covis::fuzz {
namespace {

struct Folder {
  std::filesystem::path path = scratch_folder_of(::getpid());
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() {
    std::error_code none;
    std::filesystem::remove_all(path, none);
  }
};

}  // namespace

MemoryFile::MemoryFile(std::string_view bytes) : handle_(::memfd_create("covis_fuzz", MFD_CLOEXEC)) {
  require(handle_ >= 0, "memory for a file");
  while (!bytes.empty()) {
    const ssize_t n = ::write(handle_, bytes.data(), bytes.size());
    require(n > 0, "memory for a file");
    bytes.remove_prefix(static_cast<size_t>(n));
  }
}

MemoryFile::~MemoryFile() { ::close(handle_); }

std::filesystem::path MemoryFile::path() const { return "/proc/self/fd/" + std::to_string(handle_); }

const std::filesystem::path& scratch_folder() {
  static const Folder folder;
  return folder.path;
}

std::filesystem::path scratch_folder_of(pid_t process) {
  std::error_code none;
  const std::filesystem::path memory = "/dev/shm";
  return (std::filesystem::is_directory(memory, none) ? memory : std::filesystem::temp_directory_path()) /
         ("covis_fuzz" + std::to_string(process));
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write_file(const std::filesystem::path& file, std::string_view bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace covis::fuzz
