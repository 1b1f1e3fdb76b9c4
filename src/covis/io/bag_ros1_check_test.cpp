// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag_ros1_check.h"

#include "covis/core/random.h"
#include "covis/io/bag.h"
#include "covis/io/files.h"
#include "covis/io/test_bags.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::HasSubstr;

class Ros1Records : public RecordingTest {
 protected:
  void SetUp() override {
    WrittenBag bag(RosWire::ros1);
    bag.add("/camera_info", camera_info());
    for (int i = 1; i < 5; ++i)
      bag.add_image("/image", i * Timestamp{1'000'000'000}, "mono8", std::string(32, 'a'), {8, 4});
    bag.write(folder / "whole.bag");
    whole = *read_text(folder / "whole.bag");
  }

  std::string whole;
};

TEST_F(Ros1Records, WholeBagsPass) {
  const auto checked = check_ros1_records(whole);
  EXPECT_TRUE(checked) << checked.error().message;
  WrittenBag(RosWire::ros1).write(folder / "empty.bag");
  EXPECT_TRUE(check_ros1_records(*read_text(folder / "empty.bag")));
}

TEST_F(Ros1Records, CutOnesDoNot) {
  for (size_t size = 14; size < whole.size(); size += 7) {
    const std::vector<char> cut(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size));  // no byte behind
    EXPECT_FALSE(check_ros1_records({cut.data(), cut.size()})) << size;
  }
  EXPECT_THAT(check_ros1_records(whole.substr(0, 5000)).error().message,
              HasSubstr("a record is cut short or damaged at byte 4109"));
}

std::string word(size_t value) {
  const auto number = static_cast<uint32_t>(value);
  return std::string(reinterpret_cast<const char*>(&number), sizeof number);
}

// A bag with one chunk and one index of it, whose entries lead to the chunk's places.
std::string bag_of(const std::string& compression, const std::string& chunk, size_t announced,
                   const std::vector<size_t>& places) {
  const auto field = [](const std::string& text) { return word(text.size()) + text; };
  const auto record = [](const std::string& header, const std::string& data) {
    return word(header.size()) + header + word(data.size()) + data;
  };
  std::string entries;
  for (const size_t place : places) entries += std::string(8, '\0') + word(place);
  const std::string head = field("op=\3") + field("conn_count=" + word(0)) + field("chunk_count=" + word(0)) +
                           field("index_pos=" + std::string(8, '\x7f'));
  return "#ROSBAG V2.0\n" + record(head, "") +
         record(field("op=\5") + field("compression=" + compression) + field("size=" + word(announced)), chunk) +
         record(field("op=\4") + field("ver=" + word(1)) + field("conn=" + word(0)) +
                    field("count=" + word(places.size())),
                entries);
}

TEST_F(Ros1Records, ACompressedChunkMayAnnounceSoMuch) {
  EXPECT_TRUE(check_ros1_records(bag_of("bz2", "BZh9", 128'000'000, {0})));
  EXPECT_THAT(check_ros1_records(bag_of("bz2", "BZh9", 128'000'001, {0})).error().message,
              HasSubstr("announces 129 MB, and 128 can be read; `rosbag decompress` makes a bag that can be read. "
                        "That chunk is at byte"));
  EXPECT_THAT(check_ros1_records(bag_of("bz2", "BZh9", 4'000'000'000, {0})).error().message,
              HasSubstr("a chunk of messages is damaged"))
      << "none unpacks to so much";
}

TEST_F(Ros1Records, AnIndexLeadsToMessagesInTimeProportionalToItsSize) {
  const std::string header = word(4) + "op=\7";
  const std::string connection = word(header.size()) + header + word(0);
  std::string message = connection;
  message.replace(message.find('\7'), 1, "\2");
  std::string chunk = connection + message;
  EXPECT_TRUE(check_ros1_records(bag_of("none", chunk, chunk.size(), {0, connection.size()})));
  EXPECT_FALSE(check_ros1_records(bag_of("none", chunk, chunk.size(), {1}))) << "the midst of a record";
  chunk.clear();
  constexpr size_t kConnections = 100'000;  // pairs of a connection and an index entry: 10,000 million
  for (size_t i = 0; i < kConnections; ++i) chunk += connection;
  chunk += message;
  EXPECT_FALSE(check_ros1_records(bag_of("none", chunk, chunk.size(), std::vector<size_t>(kConnections, 0))));
  const std::vector<size_t> last(kConnections, (kConnections - 1) * connection.size());
  EXPECT_TRUE(check_ros1_records(bag_of("none", chunk, chunk.size(), last)));
}

// Neither the check nor what rosbag_storage does of what passes it crashes.
TEST_F(Ros1Records, DamagedOnesAreReadOrRefused) {
  Random random(hash_seed(4, 5, 6));
  int refused = 0;
  for (int round = 0; round < 120; ++round) {
    std::string damaged = whole;
    // Padding of 4 KB behind the first record holds nothing.
    for (int k = 0; k <= round % 2; ++k)
      damaged[4109 + random.below(static_cast<uint32_t>(whole.size() - 4109))] = static_cast<char>(random.below(256));
    if (round % 4 == 0) damaged[13 + random.below(70)] = static_cast<char>(random.below(256));
    refused += !check_ros1_records(damaged);
    if (!reads_ros1_bags()) continue;
    write("damaged.bag", damaged);
    const auto bag = open_bag(folder / "damaged.bag");
    if (!bag) continue;
    std::string bytes;
    for (const BagTopic& topic : (*bag)->topics()) {
      for (const BagMessage& message : topic.messages) (void)(*bag)->read(message, bytes);
    }
  }
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace covis::io
