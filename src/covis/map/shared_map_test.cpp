// SPDX-License-Identifier: Apache-2.0
#include "covis/map/shared_map.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>
#include <type_traits>

namespace covis {
namespace {

static_assert(std::is_same_v<decltype(*std::declval<const SharedMap&>().read()), const Map&>,
              "a reader can't change it");
static_assert(!std::is_copy_constructible_v<SharedMap>, "one map, one lock");

FeaturesPtr no_features() {
  auto features = std::make_shared<Features>();
  features->pyramid = std::make_shared<ScalePyramid>(8, 1.2f);
  return features;
}

TEST(SharedMap, ReadersShare) {
  SharedMap shared;
  const auto outer = shared.read();
  // Would hang if the second reader had to wait for the first.
  std::jthread([&] { EXPECT_EQ(shared.read()->key_frame_count(), 0u); }).join();
}

TEST(SharedMap, AWriterWaitsForTheReaderAndAReaderForTheWriter) {
  SharedMap shared;
  std::atomic<bool> written{false}, seen{false};
  std::jthread writer, reader;
  {
    const auto reading = shared.read();
    writer = std::jthread([&] {
      const auto map = shared.write();
      map->add_key_frame(0, 0, SE3(), no_features());
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
    writing->attach_to_tree(writing->add_key_frame(1, 1, SE3(), no_features()));
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

}  // namespace
}  // namespace covis
