// SPDX-License-Identifier: Apache-2.0
// Places: relocalisation, saved maps, localisation only, loops; with the vocabulary that ships with Covis.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <stdexcept>
#include <thread>

#include "covis/storage/map_file.h"
#include "rendered.h"

namespace covis {
namespace {

// Serialises all state of a map that localisation must not change.
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

storage::MapHeader header_of(const Recording& recording, const SystemOptions& options) {
  storage::MapHeader header;
  header.camera = recording.synth.camera();
  header.sensor = options.sensor;
  header.levels = kFewestLevels;
  header.factor = static_cast<float>(options.orb.scale_factor);
  return header;
}

class Places : public testing::TestWithParam<Sensor> {
 protected:
  ~Places() override { std::filesystem::remove(file); }

  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) /
                                     ("covis_places_" + sensor_name(GetParam()) + "_" + std::to_string(getpid()));
};

// A desk is mapped and saved; later runs see more of it.
class SavedDesk : public Places {
 protected:
  // Maps frames 0 to 29. Each image of the last ten is found on its own, from nothing, where the run was.
  void map_and_save() {
    System system(recording.synth.camera(), options, vocabulary());
    for (int i = 0; i < 30; ++i) system.process(recording.frame(i));
    system.finish();
    const std::vector<PoseOfFrame> mapped = system.trajectory();
    ASSERT_GT(mapped.size(), 15u);
    int found = 0;
    for (int i = 29; i >= 20; --i) {
      const auto located = system.locate(recording.frame(i));
      if (!located) continue;
      ++found;
      const SE3& wanted = mapped[mapped.size() - static_cast<size_t>(30 - i)].T_wc;
      EXPECT_LT((located->T_wc.t() - wanted.t()).norm(), 0.05) << "frame " << i;
      EXPECT_LT(angle_deg(located->T_wc, wanted), 2) << "frame " << i;
    }
    EXPECT_GE(found, 9);
    EXPECT_FALSE(system.locate(recording.black(0)));
    ASSERT_TRUE(storage::save_map(file, system.map_state(), header_of(recording, options)));
    saved_bytes = bytes_of(*system.map().read());
  }
  // The map is not changed, and a black image gets no pose.
  void localise() {
    SystemOptions localize = options;
    localize.localize = true;
    System system(recording.synth.camera(), localize, vocabulary());
    auto saved = storage::load_map(file);
    ASSERT_TRUE(saved) << saved.error().message;
    ASSERT_TRUE(system.set_map(std::move(saved->map), saved->header.camera));
    EXPECT_EQ(system.process(recording.black(0)).track.state, TrackingState::lost);
    int tracked = 0;
    for (int i = 25; i < 40; ++i) tracked += system.process(recording.frame(i)).track.state == TrackingState::tracking;
    system.finish();
    EXPECT_GE(tracked, 12);
    EXPECT_EQ(bytes_of(*system.map().read()), saved_bytes);
  }
  // The new key frames are connected to the old ones.
  void go_on() {
    System system(recording.synth.camera(), options, vocabulary());
    auto saved = storage::load_map(file);
    ASSERT_TRUE(saved) << saved.error().message;
    const size_t key_frames = saved->map.key_frame_count();
    ASSERT_TRUE(system.set_map(std::move(saved->map), saved->header.camera));
    int tracked = 0;
    for (int i = 20; i < 40; ++i) {
      tracked += system.process(recording.frame(i)).track.state == TrackingState::tracking;
      ASSERT_EQ(system.map().read()->check(), "");
    }
    system.finish();
    EXPECT_GE(tracked, 18);
    EXPECT_GE(system.map().read()->key_frame_count(), key_frames);
    EXPECT_LT(error(system.trajectory(), recording.synth, GetParam() == Sensor::monocular), 0.02);
  }

  Recording& recording = shared_recording(GetParam(), 40, 15, "desk");
  const SystemOptions options = options_for(GetParam());
  std::string saved_bytes;
};

INSTANTIATE_TEST_SUITE_P(Sensors, SavedDesk, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

TEST_P(SavedDesk, IsLocalisedInAndContinued) {
  ASSERT_NO_FATAL_FAILURE(map_and_save());
  ASSERT_NO_FATAL_FAILURE(localise());
  ASSERT_NO_FATAL_FAILURE(go_on());
}

// A hall of posters is mapped, and single images of other instants are located in it, of another light.
class HallInAnotherLight : public testing::Test {
 protected:
  static constexpr int kMapped = 60, kImages = 16;
  static constexpr double kRate = 8, kImageRate = 2.3;  // frames a second

  // The number of images that are found; each must be where it was taken.
  int found(double min_shown_share) {
    SystemOptions options = options_for(Sensor::rgbd);
    options.tracker.recovery.min_shown_share = min_shown_share;
    System system(mapped.synth.camera(), options, vocabulary());
    for (int i = 0; i < kMapped; ++i) system.process(mapped.frame(i));
    system.finish();
    int count = 0;
    for (int i = 0; i < kImages; ++i) {
      const auto located = system.locate(images.frame(i));
      if (!located) continue;
      ++count;
      const SE3 truth = mapped.synth.T_wc(0).inverse() * images.synth.T_wc(i);
      EXPECT_LT((located->T_wc.t() - truth.t()).norm(), 0.1) << "image " << i;
    }
    return count;
  }

  Recording mapped{Sensor::rgbd, kMapped, kRate, "posters"};
  Recording images{Sensor::rgbd, kImages, kImageRate, "posters", {}, 0, 2};
};

TEST_F(HallInAnotherLight, IsRecognisedByWhatItsPointsLookLikeLong) {
  EXPECT_LT(found(1), kImages / 4) << "by matches alone";
  EXPECT_GE(found(RecoveryOptions{}.min_shown_share), 3 * kImages / 4);
}

// Saves a system's map repeatedly during its run, and checks each saved state.
class Saver {
 public:
  Saver(const System& system, std::filesystem::path file, const storage::MapHeader& header)
      : thread_([&system, this, file = std::move(file), header](const std::stop_token& stop) {
          while (!stop.stop_requested()) save(system, file, header);
          save(system, file, header);
        }) {}
  // Returns the number of maps saved.
  int stop() {
    thread_.request_stop();
    thread_.join();
    return saves_;
  }

 private:
  void save(const System& system, const std::filesystem::path& file, const storage::MapHeader& header) {
    const MapState state = system.map_state();
    if (state.key_frames.empty()) return std::this_thread::yield();
    const auto map = Map::from_state(state);
    ASSERT_TRUE(map) << map.error().message;
    EXPECT_EQ(map->check(), "");
    const auto saved = storage::save_map(file, state, header);
    ASSERT_TRUE(saved) << saved.error().message;
    ++saves_;
  }

  int saves_ = 0;
  std::jthread thread_;
};

// A whole run around the room, its map checked wherever a loop was closed.
struct AroundTheRoom {
  int loops = 0;
  double error = 0;  // metres
  std::string result;
};

AroundTheRoom around_the_room(System& system, Recording& recording) {
  AroundTheRoom run;
  const auto count = [&](const std::vector<MappingReport>& mapping) {
    for (const MappingReport& m : mapping) {
      run.loops += m.loop.changed_map();
      if (m.loop.changed_map() || m.full_adjustment_ms > 0) {
        EXPECT_EQ(system.map().read()->check(), "");
      }
    }
  };
  for (int i = 0; i < recording.size(); ++i) count(system.process(recording.frame(i)).mapping);
  count(system.finish());
  run.error = error(system.trajectory(), recording.synth, recording.synth.sensor() == Sensor::monocular);
  run.result = bytes(system.trajectory()) + bytes(system.online_trajectory());
  return run;
}

// With its matches aligned, an RGB-D camera meets its beginning within millimetres, and no loop is left to be closed.
SystemOptions loop_options(Sensor sensor) {
  SystemOptions options = options_for(sensor);
  options.orb.patches = sensor != Sensor::rgbd;
  return options;
}

AroundTheRoom around_the_room(Recording& recording, bool close_loops) {
  SystemOptions options = loop_options(recording.synth.sensor());
  options.loop.close = close_loops;
  System system(recording.synth.camera(), options, vocabulary());
  return around_the_room(system, recording);
}

Recording& once_around(Sensor sensor) {
  return sensor == Sensor::monocular ? shared_recording(sensor, 190, 10.0) : shared_recording(sensor, 128, 5.0);
}

// Once around the room, with a loop closed at the end.
class LoopOf : public Places {
 protected:
  const bool monocular = GetParam() == Sensor::monocular;
  Recording& recording = once_around(GetParam());

  // The loop is closed with a Saver in parallel, once for all cases.
  AroundTheRoom closed_while_saved() {
    static std::map<Sensor, AroundTheRoom> made;
    const auto at = made.find(GetParam());
    const AroundTheRoom run = at != made.end() ? at->second : made.emplace(GetParam(), run_while_saved()).first->second;
    EXPECT_GE(run.loops, 1);
    EXPECT_LT(run.error, 0.05);
    return run;
  }

 private:
  AroundTheRoom run_while_saved() {
    const SystemOptions options = loop_options(GetParam());
    System system(recording.synth.camera(), options, vocabulary());
    Saver saver(system, file, header_of(recording, options));
    AroundTheRoom run = around_the_room(system, recording);
    EXPECT_GE(saver.stop(), 2) << "one at least beside the run, and one of its end";
    const auto saved = storage::load_map(file);
    if (!saved) throw std::runtime_error(saved.error().message);
    EXPECT_EQ(saved->map.check(), "");
    EXPECT_EQ(bytes_of(saved->map), bytes_of(*system.map().read())) << "the last one is of the end";
    return run;
  }
};

INSTANTIATE_TEST_SUITE_P(Sensors, LoopOf, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

// A run without a Saver agrees to the last bit, with what loop closing does in the background too.
TEST_P(LoopOf, ARoomIsClosedAlikeWhileTheMapIsSavedLong) {
  const AroundTheRoom saved = closed_while_saved();
  EXPECT_TRUE(around_the_room(recording, true).result == saved.result);
  const AroundTheRoom open = around_the_room(recording, false);
  EXPECT_EQ(open.loops, 0);
  EXPECT_LT(saved.error, 1.1 * open.error) << "closing must not make it worse";
}

// The same in short, for the sanitizers.
using StereoLoop = LoopOf;
INSTANTIATE_TEST_SUITE_P(Sensors, StereoLoop, testing::Values(Sensor::stereo),
                         [](const auto& instance) { return sensor_name(instance.param); });

TEST_P(StereoLoop, IsClosedWhileTheMapIsSaved) { closed_while_saved(); }

}  // namespace
}  // namespace covis
