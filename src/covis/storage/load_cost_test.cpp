// SPDX-License-Identifier: Apache-2.0
// Small files that ask for much memory or time are refused; what they ask for is counted, not timed.
#include "covis/storage/load_cost.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "covis/core/test_folder.h"
#include "covis/storage/test_maps.h"
#include "covis/storage/test_sections.h"

namespace covis::storage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class LoadCost : public testing::Test {
 protected:
  std::string load(const std::string& bytes) const {
    write_file(folder / "m.covis", bytes);
    const auto loaded = load_map(folder / "m.covis");
    return loaded ? "" : loaded.error().message;
  }
  // Saves the map and loads it again.
  std::string load(const MapState& state) const {
    if (const auto saved = save_map(folder / "m.covis", state, test_header()); !saved) return saved.error().message;
    const auto loaded = load_map(folder / "m.covis");
    return loaded ? "" : loaded.error().message;
  }
  const TemporaryFolder folder;
};

// Key frames in a chain, each with the same features, all of which observe the same points.
MapState chain(uint32_t key_frames, int features) {
  Random random(1);
  const FeaturesPtr shared = random_features(random, features);
  MapState state;
  state.camera = refined_camera();
  for (uint32_t i = 0; i < key_frames; ++i) {
    KeyFrameState& k = state.key_frames.emplace_back();
    k.serial = i;
    k.features = shared;
    k.parent = i == 0 ? MapState::kNone : i - 1;
    for (int p = 0; p < features; ++p) k.points.push_back(static_cast<uint32_t>(p));
  }
  state.points.resize(static_cast<size_t>(features));
  state.root = 0;
  state.next_serial = key_frames;
  return state;
}

TEST_F(LoadCost, MeetingsAreThoseOfAWalkOverAll) {
  const MapState state = random_map(3, 500).state();
  std::vector<std::vector<uint32_t>> observers(state.points.size());
  for (uint32_t i = 0; i < state.key_frames.size(); ++i) {
    for (const uint32_t p : state.key_frames[i].points) {
      if (p != MapState::kNone) observers[p].push_back(i);
    }
  }
  uint64_t meetings = 0;
  for (const auto& list : observers) meetings += list.size() * (list.size() - 1);
  EXPECT_GT(meetings, 0u);
  EXPECT_EQ(meetings_of(state).meetings, meetings);
  uint64_t neighbours = 0;
  const Map map = *Map::from_state(state);
  map.for_each_key_frame([&](KeyFrameId, const KeyFrame& k) { neighbours += k.shared.size(); });
  EXPECT_GE(meetings_of(state).neighbours, neighbours);
  EXPECT_EQ(meetings_of(MapState()).neighbours, 0u);
}

TEST_F(LoadCost, SectionsThatGrowBeyondTheirFileAreNotUncompressed) {
  const std::string bytes = *pack_sections({{1, std::string(kUnpackedTimes * kLeastSize + 1, '\0')}});
  EXPECT_LT(bytes.size(), 1000u);
  EXPECT_THAT(load(bytes), HasSubstr("its section 'about' can't be uncompressed: with it the file would grow"));
  write_file(folder / "sum", *pack_sections({{1, std::string(600'000, '\0')}, {2, std::string(600'000, '\0')}}));
  auto file = SectionFile::open(folder / "sum");
  EXPECT_TRUE(file->read(1, "one"));
  EXPECT_THAT(file->read(2, "two").error().message, HasSubstr("more than 16 times")) << "together they are too much";
}

TEST_F(LoadCost, CountsThatTheFileCanNotHoldAreRefusedBeforeAnythingIsAllocated) {
  EXPECT_EQ(problem_of_counts(800, 0, 0, 1), "") << "a small file counts as 64 kB";
  EXPECT_THAT(problem_of_counts(1000, 0, 0, 1), HasSubstr("MB of memory, more than 40 times its size"));
  EXPECT_EQ(problem_of_counts(1000, 100'000, 2'000'000, 80'000'000), "") << "a real map's figures";
  EXPECT_THAT(problem_of_counts(UINT64_MAX, UINT64_MAX, UINT64_MAX, 80'000'000), HasSubstr("memory"));
  EXPECT_EQ(load(chain(600, 0)), "");
  EXPECT_THAT(load(chain(3000, 0)), HasSubstr("memory"));
}

TEST_F(LoadCost, PointsThatAllKeyFramesSeeAreRefused) {
  EXPECT_EQ(load(chain(100, 12)), "");
  EXPECT_THAT(load(chain(500, 12)), HasSubstr("points in common"));
  EXPECT_THAT(load(chain(400, 1)), HasSubstr("memory")) << "400 x 400 neighbours";
}

// A map like that of a long walk: each point is seen by six key frames in turn.
MapState walk(uint32_t key_frames, int features) {
  Random random(2);
  MapState state = chain(key_frames, 0);
  state.points.clear();
  for (uint32_t i = 0; i < key_frames; ++i) {
    KeyFrameState& k = state.key_frames[i];
    k.T_cw = random_pose(random);
    k.stamp = 50'000'000 * Timestamp{i};
    k.features = random_features(random, features);
    k.points.assign(static_cast<size_t>(features), MapState::kNone);
    for (uint32_t back = 0; back < 6 && back <= i; ++back) {
      for (uint32_t p = 0; p < 5; ++p) k.points[5 * back + p] = 5 * (i - back) + p;
    }
    for (int p = 0; p < 5; ++p) {
      MapPointState& point = state.points.emplace_back();
      point.position_w = {random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9)};
      point.descriptor = random_descriptor(random);
      point.reference = i;
    }
  }
  return state;
}

// Loads the file in a process of its own, which keeps nothing of the loads before. The time of the processor with the
// system's, in milliseconds; below 0 if the file could not be loaded.
double time_of_load(const fs::path& file) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return -1;
  const pid_t child = fork();
  if (child == 0) {
    const std::clock_t before = std::clock();
    const auto map = load_map(file);
    const double ms = map ? 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC : -1;
    _exit(write(ends[1], &ms, sizeof ms) == sizeof ms ? 0 : 1);
  }
  close(ends[1]);  // so that reading ends with the process
  double ms = -1;
  if (child < 0 || read(ends[0], &ms, sizeof ms) != sizeof ms) ms = -1;
  if (child > 0) waitpid(child, nullptr, 0);
  close(ends[0]);
  return ms;
}

// The figures of docs/map-format.md: storage_test --gtest_also_run_disabled_tests --gtest_filter=*Measure*
TEST_F(LoadCost, DISABLED_Measure) {
  const auto measure = [&](const char* what, const MapState& state) {
    const fs::path file = folder / "m.covis";
    ASSERT_TRUE(save_map(file, state, test_header()));
    std::vector<double> times;
    for (int round = 0; round < 9; ++round) times.push_back(time_of_load(file));
    std::sort(times.begin(), times.end());
    EXPECT_GE(times.front(), 0);
    std::printf("%s: %8.1f kB, %8.1f ms (median of 9)\n", what, static_cast<double>(fs::file_size(file)) / 1e3,
                times[4]);
  };
  for (const uint32_t size : {1000, 10000}) measure("walk", walk(size, 200));
  for (const uint32_t size : {60, 600}) measure("key frames without features", chain(size, 0));
  for (const uint32_t size : {100, 1000}) {
    MapState submaps = walk(size, 30);
    for (KeyFrameState& k : submaps.key_frames) {
      k.parent = MapState::kNone;
      k.points.assign(k.points.size(), MapState::kNone);
    }
    submaps.points.clear();
    measure("each key frame a submap", submaps);
  }
}

// How far a real map, the file that COVIS_MAP names, is from the bounds.
TEST(LoadCostOf, DISABLED_AMap) {
  const char* const file = std::getenv("COVIS_MAP");
  const auto map = load_map(file ? file : "");
  ASSERT_TRUE(map) << map.error().message;
  const MapState state = map->map.state();
  const auto size = static_cast<double>(fs::file_size(file));
  const Meetings all = meetings_of(state);
  std::printf("%zu key frames, %zu points, %.1f MB: %.3f meetings and %.4f neighbours a byte\n",
              state.key_frames.size(), state.points.size(), size / 1e6, static_cast<double>(all.meetings) / size,
              static_cast<double>(all.neighbours) / size);
}

TEST_F(LoadCost, WhatCouldNotBeLoadedIsNotSaved) {
  ASSERT_TRUE(save_map(folder / "m.covis", chain(2, 12), test_header()));
  const std::string before = read_file(folder / "m.covis");
  EXPECT_THAT(load(chain(500, 12)), HasSubstr("was not saved"));
  EXPECT_EQ(read_file(folder / "m.covis"), before);
}

}  // namespace
}  // namespace covis::storage
