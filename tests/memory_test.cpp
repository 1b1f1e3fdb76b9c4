// SPDX-License-Identifier: Apache-2.0
// A lack of memory in any thread ends what was asked for with an error, and leaves what was made.
#include <gmock/gmock.h>

#include <exception>

#include "api_frames.h"
#include "covis/core/test_allocations.h"
#include "covis/core/test_threads.h"
#include "covis/features/staged_work.h"
#include "covis/map/slot_store.h"

namespace covis {
namespace {

using testing::HasSubstr;

// Ends with its scope.
class MemoryFullForOthers {
 public:
  MemoryFullForOthers() {
    has_memory_left = true;
    memory_is_full = true;
  }
  ~MemoryFullForOthers() { memory_is_full = false; }
};

TEST(Memory, WhereMappingHasNoneTrackingSaysSoAndTheMapStays) {
  Recording recording(Sensor::rgbd, 60);
  System system(recording.synth.camera(), options_for(Sensor::rgbd));
  constexpr int kBefore = 20;
  for (int i = 0; i < kBefore; ++i) system.process(recording.frame(i));
  system.finish();
  const size_t poses = system.snapshot()->trajectory.size();
  EXPECT_GT(poses, 10u);
  const MemoryFullForOthers full;
  bool thrown = false;
  for (int i = kBefore; i < recording.size() && !thrown; ++i) {
    try {
      system.process(recording.frame(i));
    } catch (const std::bad_alloc&) {
      thrown = true;
    }
  }
  EXPECT_TRUE(thrown) << "of the mapping thread, when its result was due";
  EXPECT_GE(system.snapshot()->trajectory.size(), poses);
  for (int i = 40; i < 43; ++i) EXPECT_THROW(system.process(recording.frame(i)), std::bad_alloc) << "from then on";
  EXPECT_THROW(system.finish(), std::bad_alloc);
  EXPECT_THROW(system.set_mode(TrackingMode::localisation), std::bad_alloc);
}

TEST(Memory, TheLibraryMakesAnErrorOfIt) {
  Recording recording(Sensor::rgbd, 60);
  auto slam =
      Slam::create({.sensor = SensorType::rgbd, .camera = parameters_of(recording.synth.camera(), Sensor::rgbd)});
  ASSERT_TRUE(slam) << slam.error();
  const MemoryFullForOthers full;
  std::string error;
  for (int i = 0; i < recording.size() && error.empty(); ++i) {
    const System::Input input = recording.frame(i);
    error = error_of((*slam)->track({.stamp = input.stamp, .image = grey(input.image), .depth = depth(input.depth)}));
  }
  EXPECT_THAT(error, HasSubstr("the memory has run out"));
  (*slam)->finish();
  EXPECT_TRUE((*slam)->snapshot());
}

// Wherever it strikes: what it leaves half changed is not used again.
TEST(Memory, AfterALackInTrackingNothingIsDoneBeforeAReset) {
  Recording recording(Sensor::rgbd, 60);
  const SlamOptions options{.sensor = SensorType::rgbd,
                            .camera = parameters_of(recording.synth.camera(), Sensor::rgbd),
                            .timing = Timing::deterministic};
  int struck = 0;
  for (long failing = 1;; failing += 5) {
    const auto slam = Slam::create(options).value();
    const auto track = [&](int i) {
      const System::Input input = recording.frame(i);
      return slam->track({.stamp = input.stamp, .image = grey(input.image), .depth = depth(input.depth)});
    };
    recording.frame(0);  // rendered before
    own_failure_in = failing;
    const std::string error = error_of(track(0));
    if (std::exchange(own_failure_in, 0) > 0) break;  // there were not so many allocations
    if (error.empty()) continue;                      // it did without
    ++struck;
    EXPECT_THAT(error, HasSubstr("track: it was given up: the memory has run out")) << failing;
    EXPECT_THAT(error_of(track(1)), HasSubstr("track: it was given up: the memory has run out")) << failing;
    EXPECT_THAT(error_of(slam->set_mode(Mode::mapping)), HasSubstr("set_mode: it was given up"));
    EXPECT_TRUE(slam->tracked_points().empty());
    slam->finish();
    slam->reset();
    EXPECT_TRUE(track(0));
    EXPECT_EQ(track(1).value().state, TrackingState::tracking) << failing;
  }
  EXPECT_GT(struck, 20);
}

TEST(Memory, WithoutThreadsTheLibrarySaysSo) {
  Recording recording(Sensor::rgbd, 60);
  const SlamOptions options{.sensor = SensorType::rgbd,
                            .camera = parameters_of(recording.synth.camera(), Sensor::rgbd)};
  const auto slam = Slam::create(options).value();
  const System::Input input = recording.frame(0);
  const Frame frame{.stamp = input.stamp, .image = grey(input.image), .depth = depth(input.depth)};
  {
    const NoMoreThreads none;
    EXPECT_THAT(error_of(Slam::create(options)), HasSubstr("create: it was given up: "));
    slam->reset();
    EXPECT_THAT(error_of(slam->track(frame)), HasSubstr("track: it was given up: "));
  }
  slam->reset();
  EXPECT_EQ(error_of(slam->track(frame)), "");
}

TEST(Memory, AStoreThatHasNoneForASlotStaysAsItWas) {
  SlotStore<MapPointId, int> store;
  const auto insert_without = [&] {
    has_memory_left = false;
    memory_is_full = true;
    bool thrown = false;
    try {
      store.insert(1);
    } catch (const std::bad_alloc&) {
      thrown = true;
    }
    memory_is_full = false;
    return thrown;
  };
  EXPECT_TRUE(insert_without());
  int visited = 0;
  store.for_each([&](MapPointId, int) { ++visited; });
  EXPECT_EQ(visited, 0);
  EXPECT_EQ(store.size(), 0u);
  EXPECT_EQ(store.at(store.insert(7)), 7);
}

TEST(Memory, AStageThatFailsInAnyThreadFailsForItsCaller) {
  std::atomic<int> done{0};
  bool fails = true;
  StagedWork work({{4, [&](int) { ++done; }},
                   {4,
                    [&](int task) {
                      if (fails && task == 2) throw std::bad_alloc();
                    }},
                   {2, [&](int) { ++done; }}});
  EXPECT_THROW(work.run(), std::bad_alloc);
  EXPECT_EQ(done, 4) << "later stages are not run";
  fails = false;
  work.run();
  EXPECT_EQ(done, 10);
}

}  // namespace
}  // namespace covis
