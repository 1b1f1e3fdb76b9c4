// SPDX-License-Identifier: Apache-2.0
#include "apps/view/protocol.h"

#include <gmock/gmock.h>

#include <cstring>

namespace covis::view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Protocol, RowsComeBack) {
  const std::vector<PointRow> points{{3, {1, 2, 3}, {9, 8, 7}, 1, 4, 5}, {6, {4, 5, 6}, {}, 0, 0, 0}};
  BlockWriter out;
  out.rows(Block::points, std::span(points));
  const std::string message = out.take();
  const auto blocks = read_blocks(message);
  ASSERT_TRUE(blocks) << blocks.error().message;
  ASSERT_THAT(*blocks, SizeIs(1));
  EXPECT_EQ(blocks->front().kind, Block::points);
  EXPECT_EQ(*blocks->front().rows<PointRow>(), points);
}

TEST(Protocol, NoRowsAreNoBlock) {
  BlockWriter out;
  out.rows(Block::points, std::span<const PointRow>());
  EXPECT_TRUE(out.empty());
}

TEST(Protocol, BlocksBeginAtMultiplesOfFour) {
  BlockWriter out;
  out.text(Block::info, "12345");
  out.text(Block::texts, "[]");
  const std::string message = out.take();
  EXPECT_EQ(message.size() % 4, 0u);
  const auto blocks = read_blocks(message);
  ASSERT_THAT(*blocks, SizeIs(2));
  EXPECT_EQ((*blocks)[0].body, "12345");
  EXPECT_EQ((*blocks)[1].body, "[]");
}

TEST(Protocol, LoopsAndObservationsComeBack) {
  LoopPaths loop;
  loop.frame = 40;
  loop.kind = LoopPaths::Kind::joined;
  loop.correction = 2.5f;
  loop.before = {{1, {1, 2, 3}}};
  loop.after = {{1, {4, 5, 6}}, {2, {7, 8, 9}}};
  BlockWriter out;
  out.loop(7, loop);
  const std::vector<ObservationRow> seen{{5, 6, 7}};
  out.observations(Block::point_observations, 12, seen);
  const std::string message = out.take();
  const auto blocks = read_blocks(message);
  ASSERT_THAT(*blocks, SizeIs(2));
  const auto read = (*blocks)[0].loop();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->frame, 40);
  EXPECT_EQ(read->kind, LoopPaths::Kind::joined);
  EXPECT_FLOAT_EQ(read->correction, 2.5f);
  EXPECT_EQ(read->before, loop.before);
  EXPECT_EQ(read->after, loop.after);
  uint32_t id = 0;
  EXPECT_THAT(*(*blocks)[1].observations(id), ElementsAre(seen[0]));
  EXPECT_EQ(id, 12u);
}

// The page reads its figures in this order: frame, width, height, counts of keypoints and bytes.
TEST(Protocol, AnImageIsItsFiguresItsKeypointsAndItsPicture) {
  const std::vector<KeypointRow> keypoints{{40, 80, KeypointKind::lost}};
  BlockWriter out;
  out.image({5, 640, 480, keypoints, "jpg"});
  const std::string message = out.take();
  const auto blocks = read_blocks(message);
  ASSERT_THAT(*blocks, SizeIs(1));
  const std::string_view body = blocks->front().body;
  ASSERT_EQ(body.size(), 20u + 8 + 3);
  uint32_t figures[5];
  std::memcpy(figures, body.data(), sizeof figures);
  EXPECT_THAT(figures, ElementsAre(5, 640, 480, 1, 3));
  EXPECT_EQ(body.substr(28), "jpg");
}

TEST(Protocol, CutMessagesAreErrors) {
  BlockWriter out;
  const std::vector<EdgeRow> edges{{1, 2, 3, 0}};
  out.rows(Block::edges, std::span(edges));
  const std::string message = out.take();
  for (size_t size = 1; size < message.size(); ++size) EXPECT_FALSE(read_blocks(message.substr(0, size))) << size;
  EXPECT_THAT(*read_blocks(""), IsEmpty());
  EXPECT_FALSE(read_blocks(message)->front().rows<PointRow>());
  EXPECT_FALSE(read_blocks(message)->front().loop());
}

}  // namespace
}  // namespace covis::view
