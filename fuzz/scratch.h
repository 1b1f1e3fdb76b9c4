// SPDX-License-Identifier: Apache-2.0
// Files for readers that take names: in memory, or in a folder that goes with the process.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace covis::fuzz {

// A file in memory, for a reader that looks at no other file.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes);
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile();
  std::filesystem::path path() const;

 private:
  int handle_;
};

// A folder of the process's own, in memory where there is /dev/shm.
const std::filesystem::path& scratch_folder();
// The one of another process, which that leaves behind when it crashes.
std::filesystem::path scratch_folder_of(pid_t process);

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);  // sorted by name
std::string read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, std::string_view bytes);

}  // namespace covis::fuzz
