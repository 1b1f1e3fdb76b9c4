// SPDX-License-Identifier: Apache-2.0
// For tests and fuzzing: map files of any sections.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "covis/storage/map_file_format.h"

namespace covis::storage {

struct Section {
  uint32_t id = 0;
  std::string bytes;
};

// Returns the bytes of a file with these sections.
inline Result<std::string> pack_sections(const std::vector<Section>& sections, uint16_t major = kMapFileMajor,
                                         uint16_t minor = kMapFileMinor) {
  std::string file;
  FileSink sink(file);
  SectionWriter writer(sink, sections.size(), major, minor);
  for (const Section& section : sections) writer.write(section.id, section.bytes);
  if (const auto size = writer.finish(); !size) return tl::unexpected(size.error());
  return file;
}

}  // namespace covis::storage
