// SPDX-License-Identifier: Apache-2.0
// Snapshots of a large map (1000 key frames, 100,000 points, 500,000 observations; docs/library.md): what one costs,
// how long mapping waits for the map while one after the other is taken, and what frames take while another thread
// takes some.
#include <benchmark/benchmark.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "covis/core/quantile.h"
#include "covis/features/test_features.h"
#include "covis/slam/system.h"
#include "tests/rendered.h"

namespace covis {
namespace {

constexpr int kKeyFrames = 1000, kNewPoints = 100, kObservers = 5;

// Each key frame brings new points, which the next four see as well.
Map large_map(const Pinhole& camera) {
  Map map;
  map.set_camera(camera);
  Random random(1);
  std::vector<std::vector<MapPointId>> seen;
  for (int k = 0; k < kKeyFrames; ++k) {
    const Eigen::Vector3d at(0.1 * k, 0, 0);
    const KeyFrameId id = map.add_key_frame(k, k * Timestamp{100'000'000}, SE3(Eigen::Matrix3d::Identity(), -at),
                                            random_features(random, 1000, 2));
    uint32_t feature = 0;
    for (int back = 1; back < kObservers && back <= k; ++back) {
      for (const MapPointId point : seen[static_cast<size_t>(k - back)]) map.add_observation(point, id, feature++);
    }
    std::vector<MapPointId>& made = seen.emplace_back();
    for (int i = 0; i < kNewPoints; ++i)
      made.push_back(map.add_point(at + Eigen::Vector3d(random.uniform(-1, 1), 0, 2), id, feature++));
    map.attach_to_tree(id);
  }
  return map;
}

// The map counts as changed before each, so that every snapshot is made anew.
void copy(benchmark::State& state) {
  SharedMap map;
  *map.write() = large_map({500, 500, 320, 240, 40});
  const TrajectoryLog log;
  const SnapshotSource source(map, log);
  // Takes the write guard as mapping does, and measures the wait for the snapshot's read guard.
  std::atomic<bool> done = false;
  std::vector<double> waits;
  std::thread mapping([&] {
    while (!done) {
      const Stopwatch wait;
      static_cast<void>(map.write());
      waits.push_back(wait.ms());
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  });
  for (auto _ : state) {
    static_cast<void>(map.write());
    benchmark::DoNotOptimize(source.get());
  }
  done = true;
  mapping.join();
  state.counters["wait_median_ms"] = quantile(waits, 0.5);
  state.counters["wait_p95_ms"] = quantile(waits, 0.95);
}
BENCHMARK(copy)->Unit(benchmark::kMillisecond)->MinTime(2);

// Rendered frames are tracked and mapped in a submap beside the large map. Argument: milliseconds from one snapshot to
// the next, which another thread takes; -1: none are taken.
void frames(benchmark::State& state) {
  constexpr int kFrames = 150, kFirst = 30;  // the submap is begun between the first ones
  static Recording recording(Sensor::rgbd, kFrames, 15, "room", {640, 480});
  for (int i = 0; i < kFrames; ++i) recording.frame(i);
  // Without a vocabulary no submap is begun beside a map.
  const auto vocabulary = Vocabulary::load(COVIS_SOURCE_DIR "/vocabulary/default.covis-voc");
  if (!vocabulary) return state.SkipWithError(vocabulary.error().message.c_str());
  std::vector<double> frame_ms, snapshot_ms;
  for (auto _ : state) {
    SystemOptions options;
    options.sensor = Sensor::rgbd;
    System system(recording.synth.camera(), options, *vocabulary);
    if (!system.set_map(large_map(recording.synth.camera().pinhole), recording.synth.camera()))
      return state.SkipWithError("the map is refused");
    std::atomic<bool> done = false;
    std::thread viewer([&] {
      while (!done && state.range(0) >= 0) {
        const Stopwatch copying;
        benchmark::DoNotOptimize(system.snapshot());
        snapshot_ms.push_back(copying.ms());
        std::this_thread::sleep_for(std::chrono::milliseconds(state.range(0)));
      }
    });
    for (int i = 0; i < kFrames; ++i) {
      const FrameReport report = system.process(recording.frame(i));
      if (i >= kFirst) frame_ms.push_back(report.timing.total_ms);
    }
    done = true;
    viewer.join();
    if (system.snapshot()->submaps.size() != 2) return state.SkipWithError("the frames were not mapped");
    state.counters["key_frames"] = static_cast<double>(system.map_size().key_frames);
  }
  state.counters["frame_median_ms"] = quantile(frame_ms, 0.5);
  state.counters["frame_p95_ms"] = quantile(frame_ms, 0.95);
  state.counters["snapshots"] = static_cast<double>(snapshot_ms.size());
  state.counters["snapshot_median_ms"] = quantile(snapshot_ms, 0.5);
}
BENCHMARK(frames)->Arg(-1)->Arg(500)->Arg(100)->Arg(10)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace covis
