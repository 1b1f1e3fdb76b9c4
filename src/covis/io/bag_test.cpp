// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag.h"

#include <sys/stat.h>

#include "covis/io/files.h"
#include "covis/io/test_bags.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class BagFolder : public RecordingTest {
 protected:
  void SetUp() override {
    // Two files of one bag, as a recorder that splits leaves them.
    for (int part = 0; part < 2; ++part) {
      WrittenBag bag(RosWire::cdr);
      bag.add("/camera_info", camera_info());
      for (int i = 0; i < 2; ++i) bag.add_grey("/image", (1 + 2 * part + i) * Timestamp{1'000'000'000}, 10 * part + i);
      bag.write(folder / ("bag_" + std::to_string(part) + ".db3"));
    }
    metadata("storage_identifier: sqlite3");
  }
  void metadata(const std::string& storage) const {
    write("metadata.yaml", "rosbag2_bagfile_information:\n  version: 4\n  " + storage +
                               "\n  relative_file_paths:\n    - bag_0.db3\n    - bag/bag_1.db3\n");
  }
  std::string bag_error() const {
    const auto opened = open_bag(folder);
    EXPECT_FALSE(opened);
    return opened ? "" : opened.error().message;
  }
};

TEST_F(BagFolder, SeveralFilesAreOneRecording) {
  for (const bool with_metadata : {true, false}) {
    if (!with_metadata) fs::remove(folder / "metadata.yaml");
    auto opened = open();
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ((*opened)->kind(), SequenceKind::bag);
    ASSERT_EQ((*opened)->size(), 4);
    for (const int grey : {0, 1, 10, 11}) EXPECT_EQ((*(*opened)->next())->image(0, 0), grey);
    EXPECT_EQ((*opened)->picture(2)->bytes[0], 10);
  }
}

TEST_F(BagFolder, WhatCantBeReadSaysHowItIsConverted) {
  metadata("storage_identifier: mcap");
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("MCAP"), HasSubstr("ros2 bag convert -i " + folder.string()),
                                 HasSubstr("storage_id: sqlite3")));
  metadata("storage_identifier: sqlite3\n  compression_format: zstd");
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("zstd"), HasSubstr("ros2 bag convert")));
  metadata("storage_identifier: other");
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("metadata.yaml"), HasSubstr("'other'"), HasSubstr("sqlite3")));
  fs::remove(folder / "metadata.yaml");
  WrittenBag bag(RosWire::cdr);
  bag.messages().push_back({"/image", "sensor_msgs/Image", 1, "\x28\xb5\x2f\xfd and more"});
  bag.write(folder / "bag_0.db3");
  fs::remove(folder / "bag_1.db3");
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("zstd"), HasSubstr("ros2 bag convert")));
  write("some.mcap", "\x89MCAP0\r\n and more");
  EXPECT_THAT(open_sequence(folder / "some.mcap", {}).error().message, HasSubstr("ros2 bag convert"));
  write("some.db3.zstd", "\x28\xb5\x2f\xfd and more");
  EXPECT_THAT(open_sequence(folder / "some.db3.zstd", {}).error().message, HasSubstr("zstd"));
}

TEST_F(BagFolder, WhatIsWrongIsNamed) {
  fs::remove(folder / "bag_1.db3");
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("bag_1.db3"), HasSubstr("listed but missing")));
  write("metadata.yaml", "rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n");
  EXPECT_THAT(bag_error(), HasSubstr("relative_file_paths"));
  for (const char* name : {"bad.db3", "bad.bag"}) {
    write(name, "hello");
    EXPECT_THAT(open_sequence(folder / name, {}).error().message, AllOf(HasSubstr(name), HasSubstr("no bag")));
    fs::remove(folder / name);
  }
  write("bag_1.db3", std::string("SQLite format 3\0", 16));
  fs::remove(folder / "metadata.yaml");
  EXPECT_THAT(bag_error(), HasSubstr("bag_1.db3"));
}

TEST_F(BagFolder, DatabasesOfSomethingElse) {
  fs::remove(folder / "metadata.yaml");
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "bag_0.db3").c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "UPDATE topics SET serialization_format = 'json'", nullptr, nullptr, nullptr);
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("/camera_info"), HasSubstr("'json'"), HasSubstr("cdr")));
  sqlite3_exec(database, "DROP TABLE topics", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("bag_0.db3"), HasSubstr("no such table: topics")));
}

TEST_F(BagFolder, DatabasesThatComputeWhatIsRead) {
  const fs::path file = folder / "bag_0.db3";
  const std::string whole = *read_text(file);
  const auto error_after = [&](const char* sql) {
    write("bag_0.db3", whole);
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
    return bag_error();
  };
  EXPECT_THAT(error_after("DROP TABLE messages; CREATE VIEW Messages AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL "
                          "SELECT x + 1 FROM c) SELECT x AS id, 2 AS topic_id, x AS timestamp, 'a' AS data FROM c"),
              AllOf(HasSubstr("bag_0.db3: 'Messages' is no plain table"), HasSubstr("tables topics and messages")));
  EXPECT_THAT(error_after("DROP TABLE topics; CREATE VIRTUAL TABLE topics USING fts5(id, name, type, "
                          "serialization_format)"),
              HasSubstr("bag_0.db3: 'topics' is no plain table"));
  EXPECT_THAT(error_after("ALTER TABLE topics ADD COLUMN more AS (hex(zeroblob(1000000)))"),
              HasSubstr("bag_0.db3: 'topics' is no plain table"));
}

TEST_F(BagFolder, FilesBesideABagAreNeitherReadNorMade) {
  std::string wal = *read_text(folder / "bag_0.db3");
  wal[18] = wal[19] = 2;  // its journal is a write-ahead log
  write("50% ?#1.db3", wal);
  write("50% ?#1.db3-wal", "");
  write("50% ?#1.db3-journal", std::string(100, '\0'));
  const auto files = [&] { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); };
  const auto before = files();
  const auto opened = open_bag(folder / "50% ?#1.db3");
  ASSERT_TRUE(opened) << opened.error().message;
  std::string bytes;
  EXPECT_TRUE((*opened)->read((*opened)->topics()[1].messages[0], bytes));
  EXPECT_EQ(files(), before);
  write("bag_1.db3-wal", "\x37\x7f\x06\x82");
  EXPECT_THAT(bag_error(), AllOf(HasSubstr("bag_1.db3-wal: it holds changes"),
                                 HasSubstr("sqlite3 '" + (folder / "bag_1.db3").string() + "' 'PRAGMA")));
  fs::remove(folder / "bag_1.db3-wal");
  ASSERT_EQ(mkfifo((folder / "bag_0.db3-journal").c_str(), 0600), 0);
  EXPECT_THAT(bag_error(), HasSubstr("bag_0.db3-journal: it is a pipe or a device"));
}

TEST_F(BagFolder, WhatIsBesideALinkedBagCounts) {
  fs::create_directory(folder / "links");
  const fs::path link = folder / "links" / "linked.db3";
  fs::create_symlink("../bag_1.db3", link);
  ASSERT_TRUE(open_bag(link));
  write("bag_1.db3-journal", "\xd9\xd5");
  const auto opened = open_bag(link);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message,
              AllOf(HasSubstr("bag_1.db3-journal: an unfinished change of the bag must be undone first"),
                    HasSubstr("sqlite3 '" + fs::canonical(folder / "bag_1.db3").string() + "' .tables")));
}

// Makes the inner page of a table's tree lead to a copy of itself by each of its cells, and that to another one, so
// that the tree seems to have ten thousand million rows or more. See SQLite's description of its file format,
// section 1.6.
void multiply_rows(std::string& bytes) {
  constexpr char kInnerPage = 5;
  const auto number = [&](size_t at) {
    return 256u * static_cast<unsigned char>(bytes[at]) + static_cast<unsigned char>(bytes[at + 1]);
  };
  const auto set = [&](size_t at, size_t value) {
    for (size_t k = 0; k < 4; ++k) bytes[at + k] = static_cast<char>(value >> (24 - 8 * k));
  };
  const size_t page_size = number(16);
  size_t page = page_size;
  while (bytes[page] != kInnerPage) page += page_size;
  const std::string inner = bytes.substr(page, page_size);
  for (int copies = 0; copies < 4; ++copies) {
    const size_t next = bytes.size();
    bytes += inner;
    set(page + 8, next / page_size + 1);  // the last one's number is in the page's header
    for (size_t cell = 0; cell < number(page + 3); ++cell)
      set(page + number(page + 12 + 2 * cell), next / page_size + 1);
    page = next;
  }
  set(28, bytes.size() / page_size);
}

TEST_F(BagFolder, ATreeOfEndlessRows) {
  std::string rows = "BEGIN; DELETE FROM messages;";
  for (int i = 0; i < 60'000; ++i) rows += "INSERT INTO messages VALUES(" + std::to_string(1 + i) + ", 1, 0, '');";
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "bag_0.db3").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, (rows + "COMMIT").c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  EXPECT_TRUE(open_bag(folder));
  std::string bytes = *read_text(folder / "bag_0.db3");
  multiply_rows(bytes);
  write("bag_0.db3", bytes);
  EXPECT_THAT(bag_error(), HasSubstr("bag_0.db3: the bag can't be read: it has more rows than a file of its size"));
}

TEST_F(BagFolder, Ros1BagsNeedTheLibrary) {
  if (reads_ros1_bags()) GTEST_SKIP() << "built with rosbag_storage";
  write("some.bag", "#ROSBAG V2.0\n");
  EXPECT_THAT(open_sequence(folder / "some.bag", {}).error().message, HasSubstr("librosbag-storage-dev"));
}

}  // namespace
}  // namespace covis::io
