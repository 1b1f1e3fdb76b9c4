// SPDX-License-Identifier: Apache-2.0
// Several maps: relocalisation after a loss, a new map in an unknown place, and joining of maps.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "covis/map/map_state.h"
#include "rendered.h"

namespace covis {
namespace {

// A recording cut and reassembled: `steps` holds the recording's frame for each step.
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

// The frames before `until`, followed by the frames from `from` up to (not including) `to`.
Walk cut(Recording& recording, double fps, int until, int from, int to) {
  Walk walk{recording, fps, {}};
  walk.go(0, until);
  walk.go(from, to);
  return walk;
}

// Runs a system along a walk and checks the map after every step.
struct Walked {
  Walk& walk;
  System system;
  int merges = 0;
  size_t most_submaps = 0;         // at a time
  size_t reported = 0;             // frames reported to be tracked
  std::vector<int64_t> tentative;  // frames among them whose place was tentative

  Walked(Walk& the_walk, const SystemOptions& options)
      : walk(the_walk), system(walk.recording.synth.camera(), options, vocabulary()) {
    go_on();
  }
  // Tracks the steps the walk got since.
  void go_on() {
    for (; done_ < static_cast<int>(walk.steps.size()); ++done_) {
      const FrameReport report = system.process(walk.input(done_));
      count(report.mapping);
      most_submaps = std::max(most_submaps, system.submaps().size());
      EXPECT_EQ(system.map().read()->check(), "") << "after step " << done_;
      reported += report.track.state == TrackingState::tracking;
      if (report.track.tentative) tentative.push_back(done_);
      EXPECT_EQ(report.track.state == TrackingState::tracking, report.track.reason == NoPoseReason::none)
          << describe(report.track.reason);
    }
    count(system.finish());
    EXPECT_EQ(system.map().read()->check(), "");
  }
  // The error of the poses in one map, metres.
  double error_of(int map, bool with_scale) const {
    const auto snapshot = system.snapshot();
    return error_to(
        poses_in(snapshot->trajectory, snapshot->submaps.at(static_cast<size_t>(map)).id),
        [&](int64_t step) { return walk.truth(step); }, with_scale);
  }

 private:
  void count(const std::vector<MappingReport>& reports) {
    for (const MappingReport& report : reports) merges += report.loop.outcome == LoopOutcome::joined;
  }

  int done_ = 0;  // number of steps processed
};

class Maps : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, Maps, testing::Values(Sensor::stereo),
                         [](const auto& instance) { return sensor_name(instance.param); });
INSTANTIATE_TEST_SUITE_P(SensorsLong, Maps, testing::Values(Sensor::monocular, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

// Part of a room is mapped; the camera jumps to an unknown place and walks back to the mapped part.
Walk jump_and_way_back(Recording& recording) {
  Walk walk{recording, 8, {}};
  walk.go(0, 40);
  walk.go(90, 2);
  return walk;
}

TEST_P(Maps, AnUnknownPlaceBeginsAMapThatIsJoinedToTheOldOne) {
  const Sensor sensor = GetParam();
  Recording& recording = shared_recording(sensor, 160);
  Walk walk = jump_and_way_back(recording);
  Walked run(walk, options_for(sensor));
  EXPECT_EQ(run.most_submaps, 2u);
  EXPECT_EQ(run.merges, 1);
  const std::vector<SubmapSummary> submaps = run.system.submaps();
  ASSERT_EQ(submaps.size(), 1u);
  EXPECT_EQ(submaps[0].id, 0u) << "the older one stays where it is";
  EXPECT_GE(submaps[0].frames, walk.steps.size() - 30);
  EXPECT_EQ(run.system.trajectory().size(), submaps[0].frames);
  EXPECT_LT(run.error_of(0, sensor == Sensor::monocular), 0.1);
}

// Mapping runs beside tracking without waiting, so the second map and the merge may come at any time.
TEST_P(Maps, MapsAreJoinedInRealTimeToo) {
  const Sensor sensor = GetParam();
  Recording& recording = shared_recording(sensor, 160);
  Walk walk = jump_and_way_back(recording);
  SystemOptions options = options_for(sensor);
  options.realtime = true;
  Walked run(walk, options);
  EXPECT_GE(run.most_submaps, 2u);
  // A busy machine may have made too few key frames for a sure decision: walk along all mapped places until the merge.
  for (int more = 0; more < 5 && run.system.submaps().size() > 1; ++more) {
    walk.go(2, 90);
    walk.go(90, 2);
    run.go_on();
  }
  EXPECT_EQ(run.system.submaps().size(), 1u);
  EXPECT_GE(run.merges, 1);
}

// A walk of a camera that was carried away in the meantime: twelve steps before, thirty after it.
Walk carried_away(Recording& recording) {
  Walk walk{recording, 8, {}};
  walk.go(0, 12);
  walk.go(90, 60);
  return walk;
}

// Returns the map of the first twelve steps.
Map map_before(Walk& walk, const SystemOptions& options) {
  System system(walk.recording.synth.camera(), options, vocabulary());
  for (int step = 0; step < 12; ++step) system.process(walk.input(step));
  system.finish();
  return Map::from_state(system.map_state()).value();
}

// No map is begun beside one that is for localisation only, nor without a way to join it later.
TEST(FurtherMap, NoneIsBegunWhereItMustNotLong) {
  Recording& recording = shared_recording(Sensor::rgbd, 160);
  Walk walk = carried_away(recording);
  const MapState before = map_before(walk, options_for(Sensor::rgbd)).state();
  const struct {
    const char* name;
    void (*change)(SystemOptions&);
    bool words;
    size_t maps;
  } cases[] = {{"nothing speaks against it", [](SystemOptions&) {}, true, 2},
               {"localisation only", [](SystemOptions& o) { o.localize = true; }, true, 1},
               {"loops stay open", [](SystemOptions& o) { o.loop.close = false; }, true, 1},
               {"new_map_after=0", [](SystemOptions& o) { o.tracker.start.new_map_after = 0; }, true, 1},
               {"no vocabulary", [](SystemOptions&) {}, false, 1}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    SystemOptions options = options_for(Sensor::rgbd);
    c.change(options);
    System system(recording.synth.camera(), options, c.words ? vocabulary() : nullptr);
    ASSERT_TRUE(system.set_map(Map::from_state(before).value(), recording.synth.camera()));
    int tracked = 0;
    for (int step = 12; step < 24; ++step) {
      tracked += system.process(walk.input(step)).track.state == TrackingState::tracking;
    }
    system.finish();
    EXPECT_EQ(system.submaps().size(), c.maps);
    EXPECT_EQ(tracked > 0, c.maps > 1);
  }
}

// Beside a loaded map that is not found another is begun after the time set; the loaded one stays the first.
TEST(FurtherMap, ALoadedMapStaysTheFirst) {
  Recording& recording = shared_recording(Sensor::rgbd, 160);
  Walk walk = carried_away(recording);
  System system(recording.synth.camera(), options_for(Sensor::rgbd), vocabulary());
  ASSERT_TRUE(system.set_map(map_before(walk, options_for(Sensor::rgbd)), recording.synth.camera()));
  for (int step = 12; step < 42; ++step) system.process(walk.input(step));
  system.finish();
  EXPECT_FALSE(system.set_map(Map(), recording.synth.camera())) << "frames were tracked";
  const std::vector<SubmapSummary> submaps = system.submaps();
  ASSERT_EQ(submaps.size(), 2u);
  EXPECT_TRUE(submaps[0].loaded);
  EXPECT_FALSE(submaps[1].loaded);
  EXPECT_EQ(submaps[0].frames, 0u);
  EXPECT_GE(submaps[1].frames, 20u);
  for (const PoseOfFrame& pose : system.trajectory()) EXPECT_EQ(pose.submap, submaps[1].id);
  EXPECT_TRUE(system.online_trajectory().empty()) << "of the first map alone";
}

// A recording that jumps to another place in the same map.
struct Cut {
  Sensor sensor;
  int from, to;  // the last frame before the jump, and the first after it
};

class Kidnapped : public testing::TestWithParam<Cut> {};

std::string cut_name(const testing::TestParamInfo<Cut>& instance) {
  return sensor_name(instance.param.sensor) + std::to_string(instance.param.to);
}

INSTANTIATE_TEST_SUITE_P(CutsLong, Kidnapped,
                         testing::Values(Cut{Sensor::monocular, 160, 60}, Cut{Sensor::monocular, 150, 100},
                                         Cut{Sensor::stereo, 160, 45}, Cut{Sensor::rgbd, 160, 75},
                                         Cut{Sensor::rgbd, 140, 20}),
                         cut_name);

// metres, degrees: greatest difference of a pose from that of the same frame before the jump.
void expect_found_again(const Cut& where, Size size, double metres, double degrees) {
  Recording& recording = shared_recording(where.sensor, 160, 8, "room", size);
  Walk walk = cut(recording, 8, where.from, where.to, where.to + 20);
  Walked run(walk, options_for(where.sensor));
  const std::vector<SubmapSummary> submaps = run.system.submaps();
  ASSERT_EQ(submaps.size(), 1u);
  const auto poses = run.system.trajectory();
  const auto first =
      std::find_if(poses.begin(), poses.end(), [&](const PoseOfFrame& p) { return p.frame >= where.from; });
  ASSERT_NE(first, poses.end());
  EXPECT_LT(first->frame, where.from + 10);
  EXPECT_GE(poses.end() - first, 10);
  // Each pose must be that of the same frame before the jump. (Monocular: in units of the first median depth.)
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

// In larger images, of which the pose is known better.
using KidnappedLarge = Kidnapped;
INSTANTIATE_TEST_SUITE_P(CutsLong, KidnappedLarge, testing::Values(Cut{Sensor::monocular, 160, 60}), cut_name);

TEST_P(KidnappedLarge, IsFoundAgainWithinTenFrames) { expect_found_again(GetParam(), {640, 480}, 0.1, 3); }

// A hall of equal posters: after a jump to its other end every view looks familiar, but none has been seen before.
TEST_P(Maps, MapsAreNotJoinedByEqualPostersLong) {
  const Sensor sensor = GetParam();
  Recording& recording = shared_recording(sensor, 265, 10, "posters", {400, 300});
  Walk walk = cut(recording, 10, 60, 200, 260);
  Walked run(walk, options_for(sensor));
  EXPECT_EQ(run.most_submaps, 2u) << "else there was nothing to join";
  EXPECT_EQ(run.merges, 0);
  ASSERT_EQ(run.system.submaps().size(), 2u);
  for (const int map : {0, 1}) {
    EXPECT_GT(run.system.submaps()[static_cast<size_t>(map)].frames, sensor == Sensor::monocular ? 20u : 30u);
    EXPECT_LT(run.error_of(map, sensor == Sensor::monocular), 0.05) << "map " << map;
  }
}

// Four seconds cut out of a walk along that hall. (Without `tracker.min_expected_match_ratio` every sensor takes a
// poster for another here.)
Walk cut_along_posters(Recording& recording) { return cut(recording, 10, 60, 100, 160); }

TEST_P(Maps, APosterIsNotTakenForAnotherLong) {
  const Sensor sensor = GetParam();
  const bool monocular = sensor == Sensor::monocular;
  Recording& recording = shared_recording(sensor, 160, 10, "posters");
  Walk walk = cut_along_posters(recording);
  Walked run(walk, options_for(sensor));
  EXPECT_EQ(run.merges, 0);
  size_t frames = 0;
  for (int map = 0; map < static_cast<int>(run.system.submaps().size()); ++map) {
    EXPECT_LT(run.error_of(map, monocular), 0.1) << "map " << map;
    frames += run.system.submaps()[static_cast<size_t>(map)].frames;
  }
  EXPECT_GE(frames, walk.steps.size() - (monocular ? 80 : 35)) << "patience, and the start of a map";
  EXPECT_EQ(run.system.trajectory().size(), frames);
}

// A busy machine makes a poor map, so the bound only excludes the next poster.
TEST(Jump, IsNotToAnotherPosterInRealTimeEitherLong) {
  for (const Sensor sensor : {Sensor::stereo, Sensor::rgbd}) {
    SCOPED_TRACE(sensor_name(sensor));
    Recording& recording = shared_recording(sensor, 160, 10, "posters");
    Walk walk = cut_along_posters(recording);
    SystemOptions options = options_for(sensor);
    options.realtime = true;
    Walked run(walk, options);
    EXPECT_EQ(run.merges, 0);
    std::map<uint32_t, PoseOfFrame> first;  // the first pose of each submap
    for (const PoseOfFrame& pose : run.system.trajectory()) {
      const PoseOfFrame& begin = first.emplace(pose.submap, pose).first->second;
      const SE3 moved = begin.T_wc.inverse() * pose.T_wc,
                truly = walk.truth(begin.frame).inverse() * walk.truth(pose.frame);
      EXPECT_LT((moved.t() - truly.t()).norm(), 0.8) << "frame " << pose.frame << " in map " << pose.submap;
    }
    EXPECT_GE(run.system.trajectory().size(), 60u);
  }
}

// Another gap in that walk leads to a place at which too few points match: where these alone are asked, the camera is
// lost within a second, and its poses, which were tentative, are retracted. What these frames show is located
// afterwards.
TEST(Jump, ThatProvesWrongIsTakenBackLong) {
  Recording& recording = shared_recording(Sensor::rgbd, 160, 10, "posters");
  Walk walk = cut(recording, 10, 80, 122, 150);
  SystemOptions options = options_for(Sensor::rgbd);
  options.tracker.recovery.min_shown_share = 1;
  Walked run(walk, options);
  EXPECT_GT(run.tentative.size(), 0u);
  EXPECT_EQ(run.system.snapshot()->online.size(), run.reported - run.tentative.size());
  for (const PoseOfFrame& pose : run.system.snapshot()->online)
    EXPECT_FALSE(std::binary_search(run.tentative.begin(), run.tentative.end(), pose.frame)) << pose.frame;
  const std::vector<PoseOfFrame> final = run.system.trajectory();
  EXPECT_TRUE(std::any_of(final.begin(), final.end(), [&](const PoseOfFrame& pose) {
    return std::binary_search(run.tentative.begin(), run.tentative.end(), pose.frame);
  })) << "some of the tentative frames are located afterwards";
  EXPECT_LT(run.error_of(0, false), 0.1);
}

// The place was right: the image shows its points, and the camera is not lost.
TEST(Jump, ThatTheImageBearsOutIsKeptLong) {
  Recording& recording = shared_recording(Sensor::rgbd, 160, 10, "posters");
  Walk walk = cut(recording, 10, 80, 122, 150);
  Walked run(walk, options_for(Sensor::rgbd));
  EXPECT_GT(run.tentative.size(), 0u);
  EXPECT_EQ(run.system.snapshot()->online.size(), walk.steps.size());
  EXPECT_LT(run.error_of(0, false), 0.1);
}

// Too little may have been seen from near a right place to recognise it by that alone.
TEST(Jump, ThatIsRightIsBelievedLong) {
  Recording& recording = shared_recording(Sensor::rgbd, 160, 10, "posters");
  Walk walk = cut(recording, 10, 90, 115, 135);
  Walked run(walk, options_for(Sensor::rgbd));
  EXPECT_GT(run.tentative.size(), 0u);
  EXPECT_GE(run.system.trajectory().size(), walk.steps.size() - 5);
  EXPECT_LT(run.error_of(0, false), 0.1);
}

// A camera lost while its place is tentative has no last place near which it would be believed at once.
TEST(Jump, LostInDoubtIsInDoubtAgainLong) {
  Recording& recording = shared_recording(Sensor::rgbd, 160);
  for (const bool realtime : {false, true}) {
    SCOPED_TRACE(realtime ? "in real time" : "deterministic");
    SystemOptions options = options_for(Sensor::rgbd);
    options.realtime = realtime;
    System system(recording.synth.camera(), options, vocabulary());
    int step = 0;
    const auto show = [&](System::Input input) {
      input.frame = step;
      input.stamp = from_seconds(step++ / 8.0);
      return system.process(input).track;
    };
    std::vector<int> features;  // of each frame, as many as usual
    for (int i = 0; i <= 60; ++i) {
      const TrackResult result = show(recording.frame(i));
      ASSERT_EQ(result.state, TrackingState::tracking) << i;
      features.push_back(result.features);
      if (realtime) system.finish();  // the map of a busy machine might be too poor for the next frame
    }
    // Shows frames from another place until the first pose.
    int there = 0;
    const auto jump = [&] {
      TrackResult result;
      for (there = 20; there < 30 && result.state != TrackingState::tracking; ++there)
        result = show(recording.frame(there));
      return result;
    };
    EXPECT_TRUE(jump().tentative);
    const int believed_for_now = step - 1;
    EXPECT_EQ(show(recording.black(0)).state, TrackingState::lost);
    const TrackResult again = jump();
    EXPECT_EQ(again.state, TrackingState::tracking);
    EXPECT_TRUE(again.tentative);
    EXPECT_GT(show(recording.frame(there)).features, features[static_cast<size_t>(there)])
        << "it was found with twice as many, and is judged with as many";
    system.finish();
    for (const PoseOfFrame& pose : system.snapshot()->online) EXPECT_NE(pose.frame, believed_for_now);
  }
}

}  // namespace
}  // namespace covis
