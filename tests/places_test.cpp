// SPDX-License-Identifier: Apache-2.0
// Places: relocalisation, saved maps, localisation only, loops; with the vocabulary that ships.
#include <gtest/gtest.h>

#include <filesystem>

#include "covis/io/map_file.h"
#include "rendered.h"

namespace covis {
namespace {

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
    ASSERT_TRUE(system.set_map(std::move(saved->map), saved->header.camera));
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
    ASSERT_TRUE(system.set_map(std::move(saved->map), saved->header.camera));
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

}  // namespace
}  // namespace covis
