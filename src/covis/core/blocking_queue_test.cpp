// SPDX-License-Identifier: Apache-2.0
#include "covis/core/blocking_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

namespace covis {
namespace {

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

}  // namespace
}  // namespace covis
