// SPDX-License-Identifier: Apache-2.0
// Several maps: lost and found again, lost where it never was, joined.
#include <gtest/gtest.h>

#include <algorithm>

#include "covis/map/map_state.h"
#include "rendered.h"

namespace covis {
namespace {

// A recording cut and put together anew: which frame of it is seen at each step.
struct Walk {
  Recording& recording;
  double fps;
  std::vector<int> steps;

  void go(int from, int to) {
    for (int i = from; i != to; i += from < to ? 1 : -1) steps.push_back(i);
  }
  System::Input input(int step) {
    System::Input input = recording.frame(steps[static_cast<size_t>(step)]);
    input.frame = step;
    input.stamp = from_seconds(step / fps);
    return input;
  }
  SE3 truth(int64_t step) const { return recording.synth.T_wc(steps[static_cast<size_t>(step)]); }
};

// Runs a system along a walk and looks at the map after every step.
struct Walked {
  System system;
  int merges = 0;
  size_t most_maps = 0;  // at a time

  Walked(Walk& walk, const SystemOptions& options) : system(walk.recording.synth.camera(), options, vocabulary()) {
    for (int step = 0; step < static_cast<int>(walk.steps.size()); ++step) {
      const FrameReport report = system.process(walk.input(step));
      count(report.mapping);
      most_maps = std::max(most_maps, system.maps().size());
      EXPECT_EQ(system.map().read()->check(), "") << "after step " << step;
      EXPECT_EQ(report.track.state == TrackState::tracking, report.track.reason.empty()) << report.track.reason;
    }
    count(system.finish());
    EXPECT_EQ(system.map().read()->check(), "");
  }
  void count(const std::vector<MappingReport>& reports) {
    for (const MappingReport& report : reports) merges += report.loop.merged;
  }
};

class Maps : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, Maps, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

// Part of a room is mapped; the camera jumps to where it never was and walks back to what is mapped.
Walk jump_and_way_back(Recording& recording) {
  Walk walk{recording, 8, {}};
  walk.go(0, 40);
  walk.go(90, 2);
  return walk;
}

TEST_P(Maps, AnUnknownPlaceBeginsAMapThatIsJoinedToTheOldOne) {
  const Sensor sensor = GetParam();
  Recording recording(sensor, 160);
  Walk walk = jump_and_way_back(recording);
  SystemOptions options = options_for(sensor);
  options.tracker.new_map_after = 0.5;
  Walked run(walk, options);
  EXPECT_EQ(run.most_maps, 2u);
  EXPECT_EQ(run.merges, 1);
  const std::vector<MapSummary> maps = run.system.maps();
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].part, 0u) << "the older one stays where it is";
  EXPECT_GE(maps[0].frames, walk.steps.size() - 30);
  const auto poses = run.system.trajectory();
  EXPECT_EQ(poses.size(), maps[0].frames);
  EXPECT_LT(error_to(
                poses, [&](int64_t step) { return walk.truth(step); }, sensor == Sensor::monocular),
            0.1);
}

// Mapping beside tracking without waiting: the merge comes at any time.
TEST_P(Maps, MapsAreJoinedInRealTimeToo) {
  const Sensor sensor = GetParam();
  Recording recording(sensor, 160);
  Walk walk = jump_and_way_back(recording);
  SystemOptions options = options_for(sensor);
  options.tracker.new_map_after = 0.5;
  options.realtime = true;
  Walked run(walk, options);
  for (const MapSummary& map : run.system.maps()) EXPECT_GT(map.key_frames, 0u);
  EXPECT_LE(run.merges, 1);
}

// Nothing is begun beside a map that is for localisation only, nor without a way to join it later.
TEST(FurtherMap, NoneIsBegunWhereItMustNot) {
  Recording recording(Sensor::rgbd, 160);
  Walk walk{recording, 8, {}};
  walk.go(0, 12);
  walk.go(90, 78);
  for (const bool localize : {true, false}) {
    SystemOptions options = options_for(Sensor::rgbd);
    options.tracker.new_map_after = 0.5;
    options.loop.close = localize;
    System system(recording.synth.camera(), options, vocabulary());
    for (int step = 0; step < 12; ++step) system.process(walk.input(step));
    system.finish();
    options.localize = localize;
    auto state = Map::from_state(system.map().read()->state());
    ASSERT_TRUE(state);
    System next(recording.synth.camera(), options, vocabulary());
    ASSERT_TRUE(next.set_map(std::move(*state), recording.synth.camera()));
    for (int step = 12; step < 24; ++step) {
      EXPECT_EQ(next.process(walk.input(step)).track.state, TrackState::lost);
    }
    EXPECT_EQ(next.maps().size(), 1u);
  }
}

// A loaded map that is not found is gone on beside, after the time set; the loaded one stays the first.
TEST(FurtherMap, ALoadedMapStaysTheFirst) {
  Recording recording(Sensor::rgbd, 160);
  Walk walk{recording, 8, {}};
  walk.go(0, 12);
  walk.go(90, 60);
  SystemOptions options = options_for(Sensor::rgbd);
  options.tracker.new_map_after = 0.5;
  System system(recording.synth.camera(), options, vocabulary());
  for (int step = 0; step < 12; ++step) system.process(walk.input(step));
  system.finish();
  auto state = Map::from_state(system.map().read()->state());
  ASSERT_TRUE(state);
  System next(recording.synth.camera(), options, vocabulary());
  ASSERT_TRUE(next.set_map(std::move(*state), recording.synth.camera()));
  for (int step = 12; step < 42; ++step) next.process(walk.input(step));
  next.finish();
  const std::vector<MapSummary> maps = next.maps();
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_TRUE(maps[0].loaded);
  EXPECT_FALSE(maps[1].loaded);
  EXPECT_EQ(maps[0].frames, 0u);
  EXPECT_GE(maps[1].frames, 20u);
  for (const PoseOfFrame& pose : next.trajectory()) EXPECT_EQ(pose.map, 1);
  EXPECT_TRUE(next.online_trajectory().empty()) << "of the first map alone";
}

// A recording cut and continued elsewhere in the same map.
struct Cut {
  Sensor sensor;
  int from, to;  // the last frame before, the first after it
};

class Kidnapped : public testing::TestWithParam<Cut> {};

INSTANTIATE_TEST_SUITE_P(Cuts, Kidnapped,
                         testing::Values(Cut{Sensor::monocular, 160, 60}, Cut{Sensor::monocular, 150, 100},
                                         Cut{Sensor::stereo, 160, 45}, Cut{Sensor::rgbd, 160, 75},
                                         Cut{Sensor::rgbd, 140, 20}),
                         [](const auto& instance) {
                           return sensor_name(instance.param.sensor) + std::to_string(instance.param.to);
                         });

// metres, degrees: how far a pose may be from that of the same frame before the cut.
void expect_found_again(const Cut& cut, Size size, double metres, double degrees) {
  Recording recording(cut.sensor, 160, 8, "room", size);
  Walk walk{recording, 8, {}};
  walk.go(0, cut.from);
  walk.go(cut.to, cut.to + 20);
  Walked run(walk, options_for(cut.sensor));
  const std::vector<MapSummary> maps = run.system.maps();
  ASSERT_EQ(maps.size(), 1u);
  const auto poses = run.system.trajectory();
  const auto first =
      std::find_if(poses.begin(), poses.end(), [&](const PoseOfFrame& p) { return p.frame >= cut.from; });
  ASSERT_NE(first, poses.end());
  EXPECT_LT(first->frame, cut.from + 10);
  EXPECT_GE(poses.end() - first, 10);
  // No false pose: each is where the same frame was before. (Monocular: in units of the first median depth.)
  for (auto pose = first; pose != poses.end(); ++pose) {
    const int frame = walk.steps[static_cast<size_t>(pose->frame)];
    const auto before =
        std::find_if(poses.begin(), poses.end(), [&](const PoseOfFrame& p) { return p.frame == frame; });
    ASSERT_NE(before, poses.end());
    EXPECT_LT((pose->T_wc.t() - before->T_wc.t()).norm(), metres) << "frame " << frame;
    EXPECT_LT(angle_deg(pose->T_wc, before->T_wc), degrees) << "frame " << frame;
  }
}

TEST_P(Kidnapped, IsFoundAgainWithinTenFrames) { expect_found_again(GetParam(), {}, 0.15, 5); }

TEST_P(Kidnapped, IsFoundAgainWithinTenFramesLong) { expect_found_again(GetParam(), {640, 480}, 0.1, 3); }

// A hall of equal posters: after a jump along it everything looks known, and nothing is.
TEST_P(Maps, MapsAreNotJoinedByEqualPostersLong) {
  const Sensor sensor = GetParam();
  Recording recording(sensor, 265, 10, "posters", {400, 300});
  Walk walk{recording, 10, {}};
  walk.go(0, 100);
  walk.go(140, 240);
  SystemOptions options = options_for(sensor);
  options.tracker.new_map_after = 0.5;
  Walked run(walk, options);
  EXPECT_EQ(run.merges, 0);
}

}  // namespace
}  // namespace covis
