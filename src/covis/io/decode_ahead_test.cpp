// SPDX-License-Identifier: Apache-2.0
#include "covis/io/decode_ahead.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <set>
#include <thread>
#include <vector>

namespace covis::io {
namespace {

Frame make_frame(int64_t index, Frame memory) {
  memory.index = index;
  memory.image.resize(64, 48);
  return memory;
}

// One of them took the end, and the others waited for ever.
TEST(DecodeAhead, EachOfSeveralThreadsIsGivenTheEnd) {
  int64_t made = 0;
  DecodeAhead ahead(
      [&](Frame memory) -> DecodeAhead::Item {
        if (made == 30) return std::optional<Frame>();
        return std::optional(make_frame(made++, std::move(memory)));
      },
      3);
  std::atomic<int> taken = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (auto item = ahead.next({}); item && *item; item = ahead.next({})) ++taken;
      });
    }
  }
  EXPECT_EQ(taken, 30);
}

TEST(DecodeAhead, GivesAllInOrderInAFewImagesMemory) {
  constexpr int64_t kFrames = 200;
  constexpr int kAhead = 3;
  std::set<const uint8_t*> memories;  // used by the decoding thread until it has ended
  {
    int64_t made = 0;
    DecodeAhead ahead(
        [&](Frame memory) -> DecodeAhead::Item {
          if (made == kFrames) return std::optional<Frame>();
          if (made == 50) return ++made, fail("frame 50");
          Frame frame = make_frame(made++, std::move(memory));
          memories.insert(frame.image.row(0));
          return std::optional(std::move(frame));
        },
        kAhead);
    Frame memory;
    for (int64_t i = 0; i < kFrames; ++i) {
      auto item = ahead.next(std::move(memory));
      memory = {};
      if (i == 50) {
        ASSERT_FALSE(item);
        EXPECT_EQ(item.error().message, "frame 50");
        continue;
      }
      ASSERT_TRUE(item && *item);
      EXPECT_EQ((*item)->index, i);
      memory = std::move(**item);
    }
    for (int k = 0; k < 3; ++k) {
      const auto end = ahead.next({});
      ASSERT_TRUE(end);
      EXPECT_FALSE(*end) << "the end stays the end";
    }
  }
  // In the queue or being decoded, and with the taker; and once more after the error, which lost its memory.
  EXPECT_LE(memories.size(), static_cast<size_t>(kAhead + 2));
}

TEST(DecodeAhead, AnExceptionIsAnErrorAndThenTheEnd) {
  int made = 0;
  DecodeAhead ahead(
      [&](Frame memory) -> DecodeAhead::Item {
        if (made == 2) throw std::bad_alloc();
        return std::optional(make_frame(made++, std::move(memory)));
      },
      2);
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(ahead.next({})->has_value());
  const auto failed = ahead.next({});
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("the memory has run out"), std::string::npos);
  const auto end = ahead.next({});
  EXPECT_TRUE(end && !*end);
}

TEST(DecodeAhead, StopsAtAnyTime) {
  for (int i = 0; i < 200; ++i) {
    int64_t made = 0;
    DecodeAhead ahead(
        [&](Frame memory) -> DecodeAhead::Item { return std::optional(make_frame(made++, std::move(memory))); },
        1 + i % 4);
    for (int k = 0; k < i % 7; ++k) EXPECT_TRUE(ahead.next({}));
  }
}

}  // namespace
}  // namespace covis::io
