// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_file_format.h"

#include <gmock/gmock.h>

#include <fstream>
#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_folder.h"
#include "covis/storage/test_sections.h"

namespace covis::storage {
namespace {

using testing::HasSubstr;

TEST(MapFileFormat, ChecksumIsTheOneOfTheStandard) {
  EXPECT_EQ(crc32("123456789"), 0xcbf43926u);
  EXPECT_EQ(crc32("56789", crc32("1234")), 0xcbf43926u);
  EXPECT_EQ(crc32(""), 0u);
}

TEST(MapFileFormat, FieldsAreReadAsTheyWereWritten) {
  FieldWriter out;
  const std::vector<uint16_t> list{1, 2, 65535};
  const double array[2] = {-0.5, 1e300};
  out(uint8_t{7});
  out(int64_t{-1});
  out.list(list);
  out.array(array, 2);
  out.list(std::string("text"));
  const std::string bytes = out.take();
  EXPECT_EQ(bytes.size(), 1 + 8 + 4 + 3 * 2 + 2 * 8 + 4 + 4u) << "without padding";

  FieldReader in(bytes);
  uint8_t byte = 0;
  int64_t number = 0;
  std::vector<uint16_t> read;
  double pair[2] = {};
  std::string text;
  in(byte);
  in(number);
  in.list(read);
  in.array(pair, 2);
  EXPECT_TRUE(in.ok());
  EXPECT_FALSE(in.whole()) << "the text is left";
  in.list(text);
  EXPECT_TRUE(in.whole());
  EXPECT_EQ(byte, 7);
  EXPECT_EQ(number, -1);
  EXPECT_EQ(read, list);
  EXPECT_EQ(pair[1], 1e300);
  EXPECT_EQ(text, "text");
}

TEST(MapFileFormat, ALengthThatIsNotThereTakesNoMemory) {
  FieldWriter out;
  out(uint32_t{4'000'000'000});
  const std::string bytes = out.take();
  FieldReader in(bytes);
  std::vector<double> list{1};
  in.list(list);
  EXPECT_FALSE(in.ok());
  EXPECT_EQ(list.size(), 1u);
  int32_t number = 5;
  in(number);
  EXPECT_EQ(number, 5) << "nothing is read after the first failure";
}

class MapFileFormatFile : public testing::Test {
 protected:
  std::string error(const std::string& bytes) const {
    write_file(folder / "file", bytes);
    const auto opened = SectionFile::open(folder / "file");
    return opened ? "" : opened.error().message;
  }
  const TemporaryFolder folder;
  const std::vector<Section> sections{{1, "one"}, {2, std::string(10'000, 'x')}, {9, ""}};
};

TEST_F(MapFileFormatFile, SectionsComeBackInAnyOrder) {
  const std::string bytes = *pack_sections(sections);
  EXPECT_LT(bytes.size(), 1000u) << "compressed";
  EXPECT_EQ(*pack_sections(sections), bytes);
  write_file(folder / "file", bytes);
  auto file = SectionFile::open(folder / "file");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->size(), bytes.size());
  EXPECT_EQ(*file->read(2, "two"), sections[1].bytes);
  EXPECT_EQ(*file->read(1, "one"), "one");
  EXPECT_TRUE(file->verify_others());
  EXPECT_EQ(*file->read(9, "nine"), "");
  EXPECT_THAT(file->read(3, "three").error().message, HasSubstr("no section 'three'"));
}

TEST_F(MapFileFormatFile, PiecesOfASectionMakeTheSameBytes) {
  Random random(3);
  std::string bytes(6'000'000, '\0');  // more than the compressor looks back
  for (char& byte : bytes) byte = static_cast<char>(random.below(20));
  std::string file;
  FileSink sink(file);
  SectionWriter writer(sink, 2, kMapFileMajor, kMapFileMinor);
  writer.begin(4, bytes.size());
  for (size_t at = 0, size = 1; at < bytes.size(); at += size, size = 3 * size % 200'003)
    writer.add(std::string_view(bytes).substr(at, size));
  writer.end();
  writer.write(5, "");
  ASSERT_EQ(writer.finish().value_or(0), file.size());
  EXPECT_TRUE(file == *pack_sections({{4, bytes}, {5, ""}}));
  write_file(folder / "file", file);
  auto opened = SectionFile::open(folder / "file");
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_TRUE(*opened->read(4, "four") == bytes);
}

TEST_F(MapFileFormatFile, ASectionOfAnotherLengthThanToldIsAnError) {
  std::string file;
  FileSink sink(file);
  SectionWriter writer(sink, 1, kMapFileMajor, kMapFileMinor);
  writer.begin(4, 5);
  writer.add("four");
  writer.end();
  EXPECT_FALSE(writer.finish());
}

TEST(MapFileFormat, ASectionThatIsThereTwiceIsAnError) {
  const TemporaryFolder folder;
  const auto bytes = pack_sections({{1, "one"}, {2, "two"}, {1, "other"}});
  ASSERT_TRUE(bytes);
  std::ofstream(folder / "map", std::ios::binary) << *bytes;
  EXPECT_THAT(SectionFile::open(folder / "map").error().message,
              HasSubstr("map: it is damaged: it has section 1 twice"));
}

// To look for each of 200,000 empty sections among all others took 14 seconds.
TEST(MapFileFormat, MoreSectionsThanAMapCanHaveAreAnError) {
  const TemporaryFolder folder;
  std::vector<Section> sections;
  for (uint32_t id = 1; id <= 1001; ++id) sections.push_back({id, {}});
  std::ofstream(folder / "map", std::ios::binary) << *pack_sections(sections);
  EXPECT_THAT(SectionFile::open(folder / "map").error().message,
              HasSubstr("map: it has 1001 sections, and no map has more than 1000"));
  sections.pop_back();
  std::ofstream(folder / "map", std::ios::binary) << *pack_sections(sections);
  EXPECT_TRUE(SectionFile::open(folder / "map"));
}

TEST_F(MapFileFormatFile, WhatWasNotReadIsVerifiedToo) {
  std::string bytes = *pack_sections(sections);
  bytes.back() = static_cast<char>(~bytes.back());  // a byte of the last section
  write_file(folder / "file", bytes);
  auto file = SectionFile::open(folder / "file");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(file->read(1, "one"));
  EXPECT_THAT(file->verify_others().error().message, HasSubstr("checksum of its section '9'"));
}

TEST_F(MapFileFormatFile, HeadersThatAreWrongAreErrors) {
  const std::string bytes = *pack_sections(sections);
  EXPECT_EQ(error(bytes), "");
  EXPECT_THAT(error(bytes + "x"), HasSubstr("damaged"));
  EXPECT_THAT(error(bytes.substr(0, 20)), HasSubstr("cut off"));
  EXPECT_THAT(error("something else"), HasSubstr("not a map"));
  EXPECT_THAT(error(*pack_sections(sections, kMapFileMajor + 1)), HasSubstr("version 2."));
}

}  // namespace
}  // namespace covis::storage
