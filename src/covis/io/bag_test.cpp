// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag.h"

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

TEST_F(BagFolder, Ros1BagsNeedTheLibrary) {
  if (reads_ros1_bags()) GTEST_SKIP() << "built with rosbag_storage";
  write("some.bag", "#ROSBAG V2.0\n");
  EXPECT_THAT(open_sequence(folder / "some.bag", {}).error().message, HasSubstr("librosbag-storage-dev"));
}

}  // namespace
}  // namespace covis::io
