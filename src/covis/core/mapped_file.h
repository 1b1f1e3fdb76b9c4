// SPDX-License-Identifier: Apache-2.0
// A memory-mapped file: pages are read on first access and shared between processes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "covis/core/error.h"

namespace covis {

class MappedFile {
 public:
  static Result<std::unique_ptr<MappedFile>> open(const std::filesystem::path& file);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  MappedFile() = default;
  const std::byte* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace covis
