// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/vocabulary_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "covis/core/random.h"

namespace covis {

static_assert(std::endian::native == std::endian::little, "vocabulary files are little-endian and used in place");

namespace {

// Chains of mixed words, four side by side: they do not wait for each other.
uint64_t hash_bytes(uint64_t seed, std::span<const std::byte> bytes) {
  uint64_t lanes[4] = {mix64(seed), mix64(seed + 1), mix64(seed + 2), mix64(seed + 3)};
  size_t lane = 0, at = 0;
  for (; at < bytes.size(); at += 8, lane = (lane + 1) % 4) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<size_t>(8, bytes.size() - at));
    lanes[lane] = mix64(lanes[lane] ^ word);
  }
  uint64_t hash = mix64(bytes.size());
  for (const uint64_t value : lanes) hash = mix64(hash ^ value);
  return hash;
}

tl::unexpected<Error> fail_errno(const std::filesystem::path& file, const char* what) {
  return fail(file.string() + ": " + what + ": " + std::generic_category().message(errno));
}

struct FileHandle {  // closes itself
  int fd;
  ~FileHandle() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

VocabularyLayout::VocabularyLayout(uint64_t node_count, uint64_t word_count)
    : descriptors(sizeof(VocabularyHeader)),
      nodes(descriptors + 32 * node_count),
      weights(nodes + 8 * (node_count + 1)),
      end(weights + 4 * word_count) {}

uint64_t header_checksum(const VocabularyHeader& header) {
  return hash_bytes(1, std::as_bytes(std::span(&header, 1)).first(offsetof(VocabularyHeader, header_checksum)));
}

uint64_t vocabulary_checksum(const VocabularyHeader& header, std::span<const std::byte> content) {
  uint64_t seed = 2;
  for (const uint64_t size : {header.branching, header.depth, header.nodes, header.words}) seed = mix64(seed ^ size);
  return hash_bytes(seed, content);
}

Result<std::unique_ptr<MappedFile>> MappedFile::open(const std::filesystem::path& file) {
  const FileHandle handle{::open(file.c_str(), O_RDONLY | O_CLOEXEC)};
  if (handle.fd < 0) return fail_errno(file, "can't be opened");
  struct stat status {};
  if (::fstat(handle.fd, &status) != 0) return fail_errno(file, "can't be read");
  if (!S_ISREG(status.st_mode)) return fail(file.string() + ": it is not a regular file");
  std::unique_ptr<MappedFile> mapped(new MappedFile);
  if (status.st_size == 0) return mapped;  // nothing to map
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

Result<void> write_whole(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::error_code error;
  std::filesystem::path target = file;
  if (std::filesystem::is_symlink(file, error)) {  // the link stays, what it names is replaced
    target = std::filesystem::canonical(file, error);
    if (error) return fail(file.string() + ": the link leads nowhere");
  }
  const std::filesystem::path temporary = target.string() + ".tmp" + std::to_string(::getpid());
  const auto give_up = [&](const char* what) {
    auto failure = fail_errno(file, what);  // errno before unlink() changes it
    ::unlink(temporary.c_str());
    return failure;
  };
  {
    const FileHandle handle{::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)};
    if (handle.fd < 0) return fail_errno(file, "can't be written");
    while (!bytes.empty()) {
      const ssize_t written = ::write(handle.fd, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return give_up("can't be written");
      bytes = bytes.subspan(static_cast<size_t>(written));
    }
    if (::fsync(handle.fd) != 0) return give_up("can't be written");
  }
  if (::rename(temporary.c_str(), target.c_str()) != 0) return give_up("can't be replaced");
  return {};
}

}  // namespace covis
