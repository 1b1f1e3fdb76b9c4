// SPDX-License-Identifier: Apache-2.0
// For tests: map files written, changed, and refused.
#pragma once

#include <gmock/gmock.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "covis/core/test_folder.h"
#include "covis/storage/test_maps.h"
#include "covis/storage/test_sections.h"

namespace covis::storage {

class MapFile : public testing::Test {
 protected:
  const TemporaryFolder folder;
  std::filesystem::path file() const { return folder / "m.covis"; }
  std::string bytes_of(const Map& map) const {
    const auto saved = save_map(file(), map.state(), test_header());
    EXPECT_TRUE(saved) << saved.error().message;
    return read_file(file());
  }
  // The file's bytes with one section after `change`, the checksums right again.
  std::string with_changed(uint32_t id, const std::function<void(std::string&)>& change) const {
    auto opened = SectionFile::open(file());
    std::vector<Section> sections;
    for (uint32_t i = 1; i <= 5; ++i) sections.push_back({i, *opened->read(i, "any")});
    change(sections[id - 1].bytes);
    return *pack_sections(sections);
  }
  // Loading and asking fail, the message names the file and says so.
  void expect_refused(const std::string& bytes, const std::string& why) const {
    write_file(folder / "bad.covis", bytes);
    const auto loaded = load_map(folder / "bad.covis");
    ASSERT_FALSE(loaded);
    EXPECT_THAT(loaded.error().message, testing::StartsWith((folder / "bad.covis").string() + ": "));
    EXPECT_THAT(loaded.error().message, testing::HasSubstr(why));
  }
};

// The sections that every file has, and another one.
inline std::string with_section(SectionFile& opened, uint32_t id, const std::string& bytes) {
  std::vector<Section> sections;
  for (uint32_t i = 1; i <= 5; ++i) sections.push_back({i, *opened.read(i, "any")});
  sections.push_back({id, bytes});
  return *pack_sections(sections);
}

}  // namespace covis::storage
