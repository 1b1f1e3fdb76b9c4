// SPDX-License-Identifier: Apache-2.0
// Handles, stamps, images, the queue and the log.
#include <gmock/gmock.h>

#include <atomic>
#include <cstring>
#include <limits>
#include <string>
#include <thread>
#include <unordered_set>
#include <vector>

#include "covis/core/blocking_queue.h"
#include "covis/core/ids.h"
#include "covis/core/image.h"
#include "covis/core/log.h"
#include "covis/core/quantile.h"
#include "covis/core/reserve.h"
#include "covis/core/time.h"

namespace covis {
namespace {

TEST(ReserveOneMore, LeavesLittleUnusedAndMovesSeldom) {
  std::vector<uint32_t> list;
  size_t moved = 0;  // elements, in all
  for (uint32_t i = 0; i < 1000; ++i) {
    const size_t before = list.capacity();
    reserve_one_more(list);
    if (list.capacity() != before) moved += list.size();
    ASSERT_GT(list.capacity(), list.size());
    list.push_back(i);
    EXPECT_LE(list.capacity(), list.size() + list.size() / 4 + 6);
  }
  EXPECT_LT(moved, 6000u);
  EXPECT_EQ(list[777], 777u);
}

TEST(Id, ADefaultHandleIsInvalidAndSlotZeroIsNot) {
  EXPECT_FALSE(KeyFrameId{}.valid());
  EXPECT_TRUE((KeyFrameId{0, 0}.valid()));
  EXPECT_NE((MapPointId{3, 1}), (MapPointId{3, 2})) << "the same slot, used again";
  static_assert(!std::is_convertible_v<KeyFrameId, MapPointId>);
}

TEST(Id, OrderIsBySlotThenGeneration) {
  EXPECT_LT((MapPointId{1, 9}), (MapPointId{2, 0}));
  EXPECT_LT((MapPointId{2, 0}), (MapPointId{2, 1}));
  EXPECT_LT((MapPointId{2, 1}), MapPointId{});
}

TEST(Id, HashTellsSlotsAndGenerationsApart) {
  std::unordered_set<size_t> hashes;
  for (uint32_t slot = 0; slot < 50; ++slot) {
    for (uint32_t generation = 0; generation < 50; ++generation)
      hashes.insert(std::hash<MapPointId>{}({slot, generation}));
  }
  EXPECT_EQ(hashes.size(), 2500u);
}

TEST(Time, StampsSurviveSecondsToTheirPrecision) {
  EXPECT_EQ(from_seconds(1.5), 1'500'000'000);
  EXPECT_EQ(from_seconds(-1.5), -1'500'000'000);
  EXPECT_EQ(from_seconds(0.1 + 0.2), 300'000'000) << "rounded, not cut off";
  EXPECT_EQ(from_seconds(-(0.1 + 0.2)), -300'000'000);
  for (Timestamp t = 0; t < 10'000'000'000; t += 33'333'333) EXPECT_EQ(from_seconds(to_seconds(t)), t);
}

TEST(Time, AStopwatchRunsOnAndStartsAnew) {
  Stopwatch watch;
  double last = watch.ms();
  EXPECT_GE(last, 0);
  for (int i = 0; i < 1000; ++i) {
    const double now = watch.ms();
    ASSERT_GE(now, last);
    last = now;
  }
  while (watch.ms() < 2) {
  }
  const Stopwatch older = watch;
  watch.restart();
  EXPECT_LT(watch.ms(), older.ms());
}

TEST(Image, RowsAreAlignedAndReadablePastTheEnd) {
  for (const int width : {1, 63, 64, 65, 641}) {
    ImageU8 image(width, 5);
    EXPECT_EQ(image.width(), width);
    EXPECT_EQ(image.height(), 5);
    EXPECT_GE(image.stride(), width);
    for (int y = 0; y < 5; ++y) {
      EXPECT_EQ(reinterpret_cast<uintptr_t>(image.row(y)) % 64, 0u);
      std::memset(image.row(y), y, static_cast<size_t>(width));
    }
    // The last row's vector may be read whole: the address sanitizer looks.
    uint8_t tail[64];
    std::memcpy(tail, image.row(4) + width, 64);
    for (int y = 0; y < 5; ++y) EXPECT_EQ(image(width - 1, y), y);
  }
}

TEST(Image, MemoryIsKeptWhenItFitsAndGoesWithAMove) {
  ImageF image(100, 80);
  float* const memory = image.row(0);
  image.resize(50, 30);
  EXPECT_EQ(image.row(0), memory);
  image.resize(100, 80);
  EXPECT_EQ(image.row(0), memory);
  image(99, 79) = 3;
  ImageF moved(std::move(image));
  EXPECT_EQ(moved.row(0), memory);
  EXPECT_EQ(moved(99, 79), 3);
  EXPECT_TRUE(image.empty());  // NOLINT(bugprone-use-after-move): left empty
}

TEST(Image, AViewSeesTheOwnersPixels) {
  ImageU8 image(10, 4);
  const ImageView<uint8_t> view = image.view();
  view(9, 3) = 77;
  EXPECT_EQ(image(9, 3), 77);
  const ImageView<const uint8_t> read_only = view;
  EXPECT_EQ(read_only.row(3), image.row(3));
  EXPECT_TRUE(ImageView<uint8_t>().empty());
  EXPECT_TRUE(ImageU8().empty());
  EXPECT_FALSE(view.empty());
}

TEST(BlockingQueue, KeepsTheOrderOfEachProducer) {
  BlockingQueue<std::pair<int, int>> queue(3);
  constexpr int kItems = 2000;
  const auto produce = [&](int who) {
    for (int i = 0; i < kItems; ++i) ASSERT_TRUE(queue.push({who, i}));
  };
  std::jthread first(produce, 0), second(produce, 1);
  int next[2] = {0, 0};
  for (int i = 0; i < 2 * kItems; ++i) {
    const auto item = queue.pop();
    ASSERT_TRUE(item);
    EXPECT_EQ(item->second, next[item->first]++);
    EXPECT_LE(queue.size(), 3u);
  }
  EXPECT_EQ(queue.size(), 0u);
}

TEST(BlockingQueue, PushWaitsForRoom) {
  BlockingQueue<int> queue(1);
  ASSERT_TRUE(queue.push(1));
  std::atomic<bool> pushed{false};
  std::jthread producer([&] {
    EXPECT_TRUE(queue.push(2));
    pushed = true;
  });
  for (int i = 0; i < 1000; ++i) {
    std::this_thread::yield();
    ASSERT_FALSE(pushed);
  }
  EXPECT_EQ(queue.pop(), 1);
  producer.join();
  EXPECT_EQ(queue.pop(), 2);
}

TEST(BlockingQueue, CloseLeavesWhatIsInsideAndEndsWaits) {
  BlockingQueue<int> queue(2);
  ASSERT_TRUE(queue.push(1));
  ASSERT_TRUE(queue.push(2));
  std::jthread producer([&] { EXPECT_FALSE(queue.push(3)) << "there was never room"; });
  queue.close();
  producer.join();
  EXPECT_FALSE(queue.push(4));
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), 2);
  EXPECT_EQ(queue.pop(), std::nullopt);

  BlockingQueue<int> empty(1);
  std::jthread consumer([&] { EXPECT_EQ(empty.pop(), std::nullopt); });
  empty.close();
}

TEST(BlockingQueue, AStopEndsWaitsAndTakesNothing) {
  BlockingQueue<int> queue(1);
  std::jthread consumer([&](std::stop_token stop) { EXPECT_EQ(queue.pop(stop), std::nullopt); });
  consumer.request_stop();
  consumer.join();
  ASSERT_TRUE(queue.push(1));
  std::jthread producer([&](std::stop_token stop) { EXPECT_FALSE(queue.push(2, stop)); });
  producer.request_stop();
  producer.join();
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.size(), 0u);
}

TEST(BlockingQueue, TakesWhatCanOnlyBeMoved) {
  BlockingQueue<std::unique_ptr<int>> queue(1);
  ASSERT_TRUE(queue.push(std::make_unique<int>(5)));
  const auto item = queue.pop();
  ASSERT_TRUE(item);
  EXPECT_EQ(**item, 5);
}

TEST(Quantile, IsTheValueOfTheNearestRank) {
  const std::vector<double> values{4, 1, 3, 2};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.49), 2);
  EXPECT_EQ(quantile(values, 0.51), 3);
  EXPECT_EQ(quantile(values, 1), 4);
  EXPECT_EQ(quantile({7}, 0.95), 7);
  EXPECT_EQ(quantile({}, 0.5), 0);
}

TEST(Log, ReachesTheSinkOneMessageAtATimeAndWithoutOneIsDropped) {
  log(LogLevel::error, "nobody listens");
  std::vector<std::pair<LogLevel, std::string>> heard;  // without a lock: log() has one
  set_log_sink([&](LogLevel level, std::string_view message) { heard.emplace_back(level, message); });
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 2; ++t) {
      threads.emplace_back([] {
        for (int i = 0; i < 500; ++i) log(LogLevel::warning, "hello");
      });
    }
  }
  set_log_sink({});
  log(LogLevel::error, "nobody listens any more");
  EXPECT_EQ(heard.size(), 1000u);
  EXPECT_THAT(heard, testing::Each(testing::Pair(LogLevel::warning, "hello")));
}

}  // namespace
}  // namespace covis
