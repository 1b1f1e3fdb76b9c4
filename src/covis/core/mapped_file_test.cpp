// SPDX-License-Identifier: Apache-2.0
#include "covis/core/mapped_file.h"

#include <gmock/gmock.h>

#include "covis/core/atomic_file.h"
#include "covis/core/test_folder.h"

namespace covis {
namespace {

using testing::HasSubstr;

std::string text_of(const MappedFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()};
}

TEST(MappedFile, ShowsTheBytesEvenAfterTheFileIsReplaced) {
  const TemporaryFolder folder;
  const std::string bytes(10'000, 'x');
  write_file(folder / "file", bytes);
  const auto mapped = MappedFile::open(folder / "file");
  ASSERT_TRUE(mapped) << mapped.error().message;
  EXPECT_EQ(text_of(**mapped), bytes);
  ASSERT_TRUE(write_atomically(folder / "file", "other"));
  EXPECT_EQ(text_of(**mapped), bytes);
}

TEST(MappedFile, EmptyFilesHaveNoBytes) {
  const TemporaryFolder folder;
  write_file(folder / "empty", "");
  const auto mapped = MappedFile::open(folder / "empty");
  ASSERT_TRUE(mapped);
  EXPECT_TRUE((*mapped)->bytes().empty());
}

TEST(MappedFile, OnlyRegularFilesAreMapped) {
  const TemporaryFolder folder;
  EXPECT_THAT(MappedFile::open(folder / "none").error().message, HasSubstr("none: can't be opened"));
  EXPECT_THAT(MappedFile::open(folder.path()).error().message, HasSubstr("not a regular file"));
  EXPECT_THAT(MappedFile::open("/dev/null").error().message, HasSubstr("not a regular file"));
}

}  // namespace
}  // namespace covis
