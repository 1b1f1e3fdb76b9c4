// SPDX-License-Identifier: Apache-2.0
// Maps of several recordings become one: pieces of rendered walks, each mapped by itself, in a world of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "covis/loops/map_merging.h"
#include "rendered.h"

namespace covis {
namespace {

// The map of some frames of a recording, forward or backward; made once for all cases.
const MapState& mapped(Recording& recording, int from, int to) {
  static std::map<std::tuple<const Recording*, int, int>, MapState> made;
  const auto [at, is_new] = made.try_emplace(std::tuple(&recording, from, to));
  if (!is_new) return at->second;
  System system(recording.synth.camera(), options_for(recording.synth.sensor()), vocabulary());
  int64_t step = 0;
  for (int i = from; i != to; i += from < to ? 1 : -1) {
    System::Input input = recording.frame(i);
    input.stamp = from_seconds(static_cast<double>(step++) / 8);
    system.process(input);  // the frame stays the recording's, for the truth
  }
  system.finish();
  return at->second = system.map_state();
}

PoseOfFrame pose_of(int64_t frame, const SE3& T_wc, uint32_t submap = 0) {
  PoseOfFrame pose;
  pose.frame = frame;
  pose.T_wc = T_wc;
  pose.submap = submap;
  return pose;
}

// Several maps as one.
struct Merged {
  SharedMap map;
  MergeReport report;

  explicit Merged(Recording& recording, std::vector<MapState> maps) {
    std::vector<MergeSource> sources;
    for (MapState& one : maps) sources.push_back({std::move(one), recording.synth.sensor()});
    const auto done = merge_maps(std::move(sources), *vocabulary(), {}, map);
    EXPECT_TRUE(done) << done.error().message;
    if (done) report = *done;
    EXPECT_EQ(map.read()->check(), "");
  }
  std::vector<PoseOfFrame> key_frames(uint32_t submap) const {
    std::vector<PoseOfFrame> poses;
    const auto now = map.read();
    for (const KeyFrameId& id : now->key_frames(submap))
      poses.push_back(pose_of(now->at(id).frame, now->at(id).T_cw.inverse(), submap));
    return poses;
  }
  // RMSE of the key frames of a submap, metres.
  double error_of(const Recording& recording, uint32_t submap = 0) const {
    return error(key_frames(submap), recording.synth, recording.synth.sensor() == Sensor::monocular);
  }
};

class Merging : public testing::TestWithParam<Sensor> {
 protected:
  bool monocular() const { return GetParam() == Sensor::monocular; }
};

INSTANTIATE_TEST_SUITE_P(Sensors, Merging, testing::Values(Sensor::rgbd, Sensor::monocular),
                         [](const auto& instance) { return sensor_name(instance.param); });
INSTANTIATE_TEST_SUITE_P(SensorsLong, Merging, testing::Values(Sensor::stereo),
                         [](const auto& instance) { return sensor_name(instance.param); });

// Two walks through a room that share a part of their way, in opposite directions.
TEST_P(Merging, TwoWalksBecomeOneMap) {
  Recording& recording = shared_recording(GetParam(), 160);
  const MapState &one = mapped(recording, 0, 60), &two = mapped(recording, 100, 40);
  const Merged merged(recording, {one, two});
  ASSERT_EQ(merged.map.read()->submaps().size(), 1u);
  const JoinedPair& pair = merged.report.join.pairs.at(0);
  EXPECT_EQ(pair.refusal, JoinRefusal::none);
  EXPECT_GE(pair.claims, 3);
  EXPECT_LT(2 * pair.contrary, pair.claims);
  EXPECT_GT(pair.fused, 100);
  EXPECT_EQ(pair.S_older_younger.scale() == 1, !monocular());
  const double error = merged.error_of(recording);
  EXPECT_LT(error, 0.05);

  if (GetParam() == Sensor::rgbd) {
    const Merged again(recording, {one, two});
    EXPECT_EQ(bytes(again.key_frames(0)), bytes(merged.key_frames(0)));
  }

  // The other way around it is the same map in another world.
  const Merged turned(recording, {two, one});
  ASSERT_EQ(turned.map.read()->submaps().size(), 1u);
  EXPECT_EQ(turned.map.read()->key_frame_count(), merged.map.read()->key_frame_count());
  EXPECT_NEAR(turned.error_of(recording), error, 0.01);
  EXPECT_EQ(turned.map.read()->at(turned.map.read()->root()).frame, two.key_frames.front().frame);

  // Both walks are found in it.
  SystemOptions options = options_for(GetParam());
  options.localize = true;
  System system(recording.synth.camera(), options, vocabulary());
  ASSERT_TRUE(system.set_map(Map::from_state(merged.map.read()->state()).value(), recording.synth.camera()));
  std::vector<PoseOfFrame> found;
  for (const int i : {10, 20, 30, 45, 50, 55, 70, 80, 90}) {
    if (const auto located = system.locate(recording.frame(i))) found.push_back(pose_of(i, located->T_wc));
  }
  EXPECT_GE(found.size(), 7u);
  EXPECT_LT(covis::error(found, recording.synth, monocular()), 0.06);
}

TEST(Merge, APlaceThatNoneOfTheOthersSawStaysAMapOfItsOwn) {
  Recording &room = shared_recording(Sensor::rgbd, 160), &desk = shared_recording(Sensor::rgbd, 30, 15, "desk");
  const Merged merged(room, {mapped(room, 0, 60), mapped(desk, 0, 30), mapped(room, 100, 40)});
  const auto map = merged.map.read();
  ASSERT_EQ(map->submaps().size(), 2u);
  ASSERT_EQ(merged.report.join.maps.size(), 2u);
  EXPECT_EQ(merged.report.join.maps[0].of, (std::vector<uint32_t>{0, 2}));
  EXPECT_EQ(merged.report.join.maps[1].of, (std::vector<uint32_t>{1}));
  EXPECT_LT(merged.error_of(room, 0), 0.05);
  EXPECT_LT(merged.error_of(desk, 1), 0.05);
}

// A hall of equal posters, and two rooms that are equal in everything: pieces that share no place. By one camera, whose
// twin rooms come nearest to being joined (docs/notes/032-merging-maps.md).
TEST(Merge, PlacesThatOnlyLookAlikeAreNotJoinedLong) {
  const struct {
    const char* world;
    int frames;
    double fps;
    std::vector<std::pair<int, int>> pieces;
  } cases[] = {{"posters", 265, 10, {{0, 60}, {100, 160}, {260, 200}}}, {"twins", 190, 8, {{0, 80}, {100, 190}}}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.world);
    Recording& recording = shared_recording(Sensor::monocular, c.frames, c.fps, c.world, {400, 300});
    std::vector<MapState> maps;
    for (const auto& [from, to] : c.pieces) maps.push_back(mapped(recording, from, to));
    const Merged merged(recording, maps);
    for (const JoinedPair& pair : merged.report.join.pairs) {
      const auto of = [&](uint32_t submap) {
        size_t i = 0;
        while (std::ranges::count(merged.report.inputs[i].submaps, submap) == 0) ++i;
        return i;
      };
      if (of(pair.older) != of(pair.younger)) {
        EXPECT_NE(pair.refusal, JoinRefusal::none) << pair.older << " and " << pair.younger;
      }
    }
  }
}

}  // namespace
}  // namespace covis
