// SPDX-License-Identifier: Apache-2.0
#include "covis/map/shared_map.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>
#include <type_traits>
#include <vector>

#include "covis/features/test_features.h"

namespace covis {
namespace {

static_assert(std::is_same_v<decltype(*std::declval<const SharedMap&>().read()), const Map&>,
              "a reader can't change it");
static_assert(!std::is_copy_constructible_v<SharedMap>, "one map, one lock");

TEST(SharedMap, ReadersShare) {
  SharedMap shared;
  const auto outer = shared.read();
  // Would hang if the second reader had to wait for the first.
  std::jthread([&] { EXPECT_EQ(shared.read()->key_frame_count(), 0u); }).join();
}

TEST(SharedMap, TheRevisionRisesWithWritersOnly) {
  SharedMap shared;
  const uint64_t before = shared.revision();
  (void)shared.read();
  EXPECT_EQ(shared.revision(), before);
  {
    const auto map = shared.write();
    EXPECT_GT(shared.revision(), before) << "from the start of a change on: a reader then waits for its end";
  }
  const uint64_t after = shared.revision();
  (void)shared.read();
  EXPECT_EQ(shared.revision(), after);
}

TEST(SharedMap, AWriterWaitsForTheReaderAndAReaderForTheWriter) {
  SharedMap shared;
  std::atomic<bool> written{false}, seen{false};
  std::jthread writer, reader;
  {
    const auto reading = shared.read();
    writer = std::jthread([&] {
      const auto map = shared.write();
      map->add_key_frame(0, 0, SE3(), std::make_shared<Features>(no_features()));
      written = true;
    });
    for (int i = 0; i < 1000; ++i) {
      std::this_thread::yield();
      ASSERT_FALSE(written);
      ASSERT_EQ(reading->key_frame_count(), 0u);
    }
  }
  writer.join();
  {
    const auto writing = shared.write();
    reader = std::jthread([&] {
      EXPECT_EQ(shared.read()->key_frame_count(), 2u) << "it saw a change half done";
      seen = true;
    });
    for (int i = 0; i < 1000; ++i) {
      std::this_thread::yield();
      ASSERT_FALSE(seen);
    }
    writing->attach_to_tree(writing->add_key_frame(1, 1, SE3(), std::make_shared<Features>(no_features())));
  }
  reader.join();
  EXPECT_TRUE(seen);
}

TEST(SharedMap, AGuardHandedOnKeepsTheLockUntilItEnds) {
  SharedMap shared;
  std::atomic<bool> written{false};
  std::jthread writer;
  {
    std::optional<SharedMap::ReadGuard> kept(shared.read());
    const SharedMap::ReadGuard moved = std::move(*kept);
    kept.reset();
    writer = std::jthread([&] {
      const auto map = shared.write();
      written = true;
    });
    for (int i = 0; i < 1000; ++i) {
      std::this_thread::yield();
      ASSERT_FALSE(written);
    }
    EXPECT_EQ(moved->point_count(), 0u);
  }
  writer.join();
  EXPECT_TRUE(written);
}

TEST(SharedMap, ReadersAndAWriterTakeTurns) {
  SharedMap shared;
  std::jthread writer([&] {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
      const auto map = shared.write();
      const KeyFrameId id = map->add_key_frame(i, i, SE3(), random_features(random, 5, 0));
      if (id != map->root()) map->attach_to_tree(id);
    }
  });
  std::vector<std::jthread> readers;
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&] {
      size_t last = 0;
      for (int i = 0; i < 100; ++i) {
        const auto map = shared.read();
        EXPECT_GE(map->key_frame_count(), last);
        last = map->key_frame_count();
        EXPECT_EQ(map->check(), "");
      }
    });
  }
  readers.clear();
  writer.join();
  EXPECT_EQ(shared.read()->key_frame_count(), 200u);
}

}  // namespace
}  // namespace covis
