// SPDX-License-Identifier: Apache-2.0
// Places: relocalisation, saved maps, localisation only, loops; with the vocabulary that ships.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "covis/io/map_file.h"
#include "covis/vocabulary/vocabulary.h"
#include "rendered.h"

namespace covis {
namespace {

std::shared_ptr<const Vocabulary> vocabulary() {
  static const auto loaded = Vocabulary::load(std::filesystem::path(COVIS_SOURCE_DIR) / "vocabulary/default.covis-voc");
  return loaded.value();
}

double angle_deg(const SE3& a, const SE3& b) {
  return so3_log(a.R() * b.R().transpose()).norm() * 180 / std::numbers::pi;
}

// All state of a map that localisation must leave alone.
std::string bytes_of(const Map& map) {
  std::string text;
  const auto add = [&](const auto& value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const MapState state = map.state();
  for (const KeyFrameState& k : state.key_frames) {
    for (int i = 0; i < 9; ++i) add(k.T_cw.R().data()[i]);
    for (int i = 0; i < 3; ++i) add(k.T_cw.t()[i]);
    for (const uint32_t p : k.points) add(p);
  }
  for (const MapPointState& p : state.points) {
    for (int i = 0; i < 3; ++i) add(p.position_w[i]);
    add(p.visible);
    add(p.found);
  }
  return text;
}

class Places : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, Places, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

TEST_P(Places, ASavedMapIsLocalisedInAndGoneOnWith) {
  const Sensor sensor = GetParam();
  Recording recording(sensor, 40, 15, "desk");
  const SystemOptions options = options_for(sensor);
  const auto file =
      std::filesystem::path(testing::TempDir()) / ("covis_places_" + std::to_string(static_cast<int>(sensor)));
  std::vector<SE3> mapped;
  std::string before;
  {
    System system(recording.synth.camera(), options, vocabulary());
    for (int i = 0; i < 30; ++i) system.process(recording.frame(i));
    system.finish();
    for (const PoseOfFrame& pose : system.trajectory()) mapped.push_back(pose.T_wc);
    ASSERT_GT(mapped.size(), 15u);
    // Each image on its own, from nothing.
    int found = 0;
    for (int i = 29; i >= 20; --i) {
      const auto T_wc = system.locate(recording.frame(i));
      if (!T_wc) continue;
      ++found;
      const SE3& wanted = mapped[mapped.size() - static_cast<size_t>(30 - i)];
      EXPECT_LT((T_wc->T_wc.t() - wanted.t()).norm(), 0.05) << "frame " << i;
      EXPECT_LT(angle_deg(T_wc->T_wc, wanted), 2) << "frame " << i;
    }
    EXPECT_GE(found, 9);
    EXPECT_FALSE(system.locate(recording.black(0)));
    const MapState state = system.map().read()->state();
    io::MapHeader header;
    header.camera = recording.synth.camera();
    header.sensor = sensor;
    header.levels = options.orb.levels;
    header.factor = static_cast<float>(options.orb.scale_factor);
    ASSERT_TRUE(io::save_map(file, state, header));
    before = bytes_of(*system.map().read());
  }
  {  // Localisation only: the map is left alone, and a black image is not invented a pose for.
    SystemOptions localize = options;
    localize.localize = true;
    System system(recording.synth.camera(), localize, vocabulary());
    auto saved = io::load_map(file);
    ASSERT_TRUE(saved) << saved.error().message;
    system.set_map(std::move(saved->map));
    EXPECT_EQ(system.process(recording.black(0)).track.state, TrackState::lost);
    int tracked = 0;
    for (int i = 25; i < 40; ++i) tracked += system.process(recording.frame(i)).track.state == TrackState::tracking;
    system.finish();
    EXPECT_GE(tracked, 12);
    EXPECT_EQ(bytes_of(*system.map().read()), before);
  }
  {  // Going on: the new key frames join the old ones.
    System system(recording.synth.camera(), options, vocabulary());
    auto saved = io::load_map(file);
    ASSERT_TRUE(saved);
    const size_t key_frames = saved->map.key_frame_count();
    system.set_map(std::move(saved->map));
    int tracked = 0;
    for (int i = 20; i < 40; ++i) {
      tracked += system.process(recording.frame(i)).track.state == TrackState::tracking;
      ASSERT_EQ(system.map().read()->check(), "");
    }
    system.finish();
    EXPECT_GE(tracked, 18);
    EXPECT_GE(system.map().read()->key_frame_count(), key_frames);
    EXPECT_LT(error(system.trajectory(), recording.synth, sensor == Sensor::monocular), 0.02);
  }
  std::filesystem::remove(file);
}

// Once round the room: the loop is closed, the map stays sound at every step, and two runs agree to the last bit.
TEST_P(Places, ALoopIsClosedLong) {
  const Sensor sensor = GetParam();
  Recording recording(sensor, 300, 15, "room", {640, 480});
  std::string first;
  double closed_error = 0, open_error = 0;
  for (int run = 0; run < 3; ++run) {
    SystemOptions options = options_for(sensor);
    options.loop.close = run < 2;
    System system(recording.synth.camera(), options, vocabulary());
    int loops = 0;
    for (int i = 0; i < recording.size(); ++i) {
      const FrameReport report = system.process(recording.frame(i));
      for (const MappingReport& m : report.mapping) {
        loops += m.loop.loop.valid();
        if (m.loop.loop.valid() || m.loop.full_ba_ms > 0) {
          ASSERT_EQ(system.map().read()->check(), "");
        }
      }
    }
    for (const MappingReport& m : system.finish()) loops += m.loop.loop.valid();
    ASSERT_EQ(system.map().read()->check(), "");
    const double e = error(system.trajectory(), recording.synth, sensor == Sensor::monocular);
    if (run == 2) {
      EXPECT_EQ(loops, 0);
      open_error = e;
      break;
    }
    closed_error = e;
    EXPECT_GE(loops, 1);
    const std::string result = bytes(system.trajectory()) + bytes(system.online_trajectory());
    if (run == 0) first = result;
    EXPECT_EQ(result, first);
  }
  EXPECT_LT(closed_error, 0.02);
  EXPECT_LT(closed_error, 1.1 * open_error) << "closing must not make it worse";
}

// A recording cut and put together anew: which frame of it is seen at each step.
struct Walk {
  Recording& recording;
  double fps;
  std::vector<int> steps;

  void go(int from, int to, int stride = 1) {
    for (int i = from; from < to ? i < to : i > to; i += from < to ? stride : -stride) steps.push_back(i);
  }
  System::Input input(int step) {
    System::Input input = recording.frame(steps[static_cast<size_t>(step)]);
    input.frame = step;
    input.stamp = from_seconds(step / fps);
    return input;
  }
  SE3 truth(int64_t step) const { return recording.synth.T_wc(steps[static_cast<size_t>(step)]); }
  // Root mean square distance of the poses in one map to the truth, metres.
  double error_of(const std::vector<PoseOfFrame>& poses, int map, bool with_scale) const {
    std::vector<Eigen::Vector3d> estimate, wanted;
    for (const PoseOfFrame& pose : poses) {
      if (pose.map != map) continue;
      estimate.push_back(pose.T_wc.t());
      wanted.push_back(truth(pose.frame).t());
    }
    const auto alignment = align(estimate, wanted, with_scale);
    return alignment ? alignment->rmse : std::numeric_limits<double>::quiet_NaN();
  }
};

// Runs a system along a walk and looks at the map after every step.
struct Walked {
  System system;
  int tracked = 0;
  int merges = 0;
  size_t most_maps = 0;  // at a time

  Walked(Walk& walk, const SystemOptions& options) : system(walk.recording.synth.camera(), options, vocabulary()) {
    for (int step = 0; step < static_cast<int>(walk.steps.size()); ++step) {
      const FrameReport report = system.process(walk.input(step));
      tracked += report.track.state == TrackState::tracking;
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

// Part of a room is mapped; the camera jumps to where it never was and walks back to what is mapped.
Walk jump_and_way_back(Recording& recording) {
  Walk walk{recording, 8, {}};
  walk.go(0, 40);
  walk.go(90, 2);
  return walk;
}

TEST_P(Places, AnUnknownPlaceBeginsAMapThatIsJoinedToTheOldOne) {
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
  EXPECT_LT(walk.error_of(poses, 0, sensor == Sensor::monocular), 0.1);
}

// Mapping beside tracking without waiting: the merge comes at any time.
TEST_P(Places, MapsAreJoinedInRealTimeToo) {
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
TEST(Maps, NoneIsBegunWhereItMustNot) {
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
    next.set_map(std::move(*state));
    for (int step = 12; step < 24; ++step) {
      EXPECT_EQ(next.process(walk.input(step)).track.state, TrackState::lost);
    }
    EXPECT_EQ(next.maps().size(), 1u);
  }
}

// A loaded map that is not found is gone on beside, after the time set; the loaded one stays the first.
TEST(Maps, ALoadedMapStaysTheFirst) {
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
  next.set_map(std::move(*state));
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
TEST_P(Places, MapsAreNotJoinedByEqualPostersLong) {
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
