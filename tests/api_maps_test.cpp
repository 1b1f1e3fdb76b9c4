// SPDX-License-Identifier: Apache-2.0
// Maps and modes of the public interface on rendered recordings.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "api_frames.h"
#include "covis/core/test_folder.h"

namespace covis {
namespace {

using ::testing::HasSubstr;

// Saved by one program, the map is continued by another, localised in by a third, and loaded into a running one.
class ApiMap : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, ApiMap, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

TEST_P(ApiMap, IsSavedContinuedAndLocalisedIn) {
  Recording& recording = shared_recording(GetParam(), 30, 15, "desk");
  const TemporaryFolder folder;
  const std::string file = folder / "map.m";
  SlamOptions options = options_of(recording);
  const auto first = Slam::create(options).value();
  track_all(*first, recording, 0, 24);
  first->finish();
  ASSERT_EQ(error_of(first->save_map(file)), "");
  const size_t key_frames = first->snapshot()->key_frames.size(), points = first->snapshot()->points.size();

  options.map = file;
  const auto second = Slam::create(options).value();
  EXPECT_EQ(second->snapshot()->key_frames.size(), key_frames);
  ASSERT_EQ(second->snapshot()->submaps.size(), 1u);
  EXPECT_TRUE(second->snapshot()->submaps[0].loaded);
  EXPECT_GE(track_all(*second, recording, 5, 29), 24);
  second->finish();
  EXPECT_GE(second->snapshot()->key_frames.size(), key_frames);

  options.mode = Mode::localisation;
  const auto third = Slam::create(options).value();
  EXPECT_EQ(third->mode(), Mode::localisation);
  EXPECT_GE(track_all(*third, recording, 0, 24), 24);
  third->finish();
  EXPECT_EQ(third->snapshot()->key_frames.size(), key_frames) << "the map is not changed";
  EXPECT_EQ(third->snapshot()->points.size(), points);
  EXPECT_EQ(third->snapshot()->trajectory.size(), 25u);

  // A map that does not load leaves everything as it was.
  EXPECT_THAT(error_of(third->load_map(kVocabulary)), HasSubstr("default.covis-voc"));
  EXPECT_EQ(third->snapshot()->trajectory.size(), 25u);
  third->reset();
  EXPECT_EQ(third->mode(), Mode::mapping);
  EXPECT_TRUE(third->snapshot()->key_frames.empty());
  ASSERT_EQ(error_of(third->load_map(file)), "");
  EXPECT_EQ(third->snapshot()->key_frames.size(), key_frames);
  EXPECT_GE(track_all(*third, recording, 0, 9), 9);
}

// A map that another camera goes on with: its key frames' pixels are those of the camera that made them.
TEST(ApiMaps, KeyFramesNameTheCameraThatMadeThem) {
  Recording& recording = shared_recording(Sensor::rgbd, 30, 15, "desk");
  const TemporaryFolder folder;
  SlamOptions options = options_of(recording);
  const auto first = Slam::create(options).value();
  track_all(*first, recording, 0, 9);
  first->finish();
  const auto before = first->snapshot();
  EXPECT_EQ(before->cameras.size(), 1u);
  EXPECT_EQ(before->cameras[0].fx, before->camera.fx);
  ASSERT_EQ(error_of(first->save_map(folder / "map.m")), "");

  options.map = folder / "map.m";
  options.camera.fx *= 1.5;
  options.camera.fy *= 1.5;
  const auto after = Slam::create(options).value()->snapshot();
  EXPECT_NEAR(after->camera.fx, options.camera.fx, 1e-9);
  ASSERT_EQ(after->cameras.size(), 2u);
  EXPECT_EQ(after->cameras[0].fx, after->camera.fx);
  EXPECT_NEAR(after->cameras[1].fx, before->camera.fx, 1e-9);
  EXPECT_EQ(after->cameras[1].width, before->camera.width);
  for (const auto& key_frame : after->key_frames) EXPECT_EQ(key_frame.camera, 1);
  ASSERT_EQ(after->observations.size(), before->observations.size());
  for (size_t i = 0; i < after->observations.size(); ++i)
    ASSERT_NEAR(after->observations[i].u, before->observations[i].u, 0.1) << i;
}

// Mapping is switched off for a while: the map stays as it is, and grows again afterwards.
TEST(ApiModes, MappingIsSwitchedOffAndOnWhileItRuns) {
  Recording& recording = shared_recording(Sensor::rgbd, 60, 8);
  const auto slam = Slam::create(options_of(recording)).value();
  EXPECT_EQ(track_all(*slam, recording, 0, 19), 20);
  ASSERT_EQ(error_of(slam->set_mode(Mode::localisation)), "");
  const size_t before = slam->snapshot()->key_frames.size(), points = slam->snapshot()->points.size();
  track_all(*slam, recording, 20, 24);
  slam->finish();
  EXPECT_EQ(slam->snapshot()->key_frames.size(), before);
  EXPECT_EQ(slam->snapshot()->points.size(), points);
  ASSERT_EQ(error_of(slam->set_mode(Mode::mapping)), "");
  EXPECT_EQ(slam->mode(), Mode::mapping);
  EXPECT_GE(track_all(*slam, recording, 25, 59), 30);
  slam->finish();
  EXPECT_GT(slam->snapshot()->key_frames.size(), before);
  EXPECT_EQ(slam->snapshot()->submaps.size(), 1u) << "it went on where it was";
}

// Away from the map, dead reckoning carries the camera in localisation only. When mapping begins from such a pose the
// camera is lost until it sees the map, and a place that it then claims is tentative.
TEST(ApiModes, DeadReckoningIsNotMappedFrom) {
  Recording& recording = shared_recording(Sensor::rgbd, 60, 8);
  SlamOptions options = options_of(recording);
  options.settings = {{"tracker.new_map_after", "0"}};
  const auto slam = Slam::create(options).value();
  track_all(*slam, recording, 0, 9);
  ASSERT_EQ(error_of(slam->set_mode(Mode::localisation)), "");
  const size_t before = slam->snapshot()->key_frames.size();
  int64_t stamp = recording.synth.stamp(9);
  const auto show = [&](int i) {
    System::Input in = recording.frame(i);
    in.stamp = stamp += from_seconds(0.125);
    return slam->track(frame_of(in)).value();
  };
  int i = 10;
  FrameResult carried = show(i);
  while (i < 49 && !carried.dead_reckoned) carried = show(++i);
  ASSERT_TRUE(carried.dead_reckoned && carried.tracked());
  for (int more = 0; more < 3; ++more) carried = show(++i);
  ASSERT_TRUE(carried.dead_reckoned);
  ASSERT_EQ(error_of(slam->set_mode(Mode::mapping)), "");
  const FrameResult away = show(++i);
  EXPECT_FALSE(away.tracked());
  EXPECT_EQ(away.reason, NoPoseReason::no_key_frame_matches);
  FrameResult back = show(5);
  for (int k = 0; k < 5 && !back.tracked(); ++k) back = show(5);
  EXPECT_TRUE(back.tracked());
  slam->finish();
  EXPECT_EQ(slam->snapshot()->key_frames.size(), before);
}

// A camera carried from a desk into a room, and a picture of each.
TEST(ApiMaps, APoseSaysInWhichMapItIs) {
  Recording desk(Sensor::rgbd, 20, 30, "desk"), room(Sensor::rgbd, 20, 30, "room");
  SlamOptions options = options_of(desk);
  options.settings = {{"tracker.new_map_after", "0.2"}};
  const auto slam = Slam::create(options).value();
  for (Recording* recording : {&desk, &room}) {
    const int map = recording == &room;
    int tracked = 0;
    for (int i = 0; i < recording->size(); ++i) {
      System::Input in = recording->frame(i);
      in.stamp += map * from_seconds(10);
      const auto result = slam->track(frame_of(in));
      ASSERT_TRUE(result) << result.error();
      if (!result->tracked()) continue;
      ++tracked;
      EXPECT_EQ(result->submap, map) << i;
    }
    EXPECT_GE(tracked, 10);
  }
  slam->finish();
  for (Recording* recording : {&desk, &room}) {
    const int map = recording == &room;
    const auto found = slam->locate(frame_of(recording->frame(19)));
    ASSERT_TRUE(found && *found) << map;
    EXPECT_EQ((*found)->submap, map);
    const auto snapshot = slam->snapshot();
    const auto& points = snapshot->points;
    EXPECT_GT(std::count_if(points.begin(), points.end(), [&](const auto& p) { return p.submap == map; }), 100);
    for (const TrajectoryPose& pose : snapshot->trajectory) EXPECT_EQ(pose.submap, pose.stamp >= from_seconds(10));
    for (const auto& key_frame : snapshot->key_frames) EXPECT_EQ(key_frame.submap, key_frame.stamp >= from_seconds(10));
  }
}

// After a jump back to the place 40 frames earlier the camera relocalises, and its poses are tentative for a second.
TEST(ApiMaps, APoseAfterAJumpIsTentativeForASecond) {
  Recording recording(Sensor::rgbd, 61);
  const auto slam = Slam::create(options_of(recording)).value();
  int64_t stamp = 0;
  const auto show = [&](int i) {
    System::Input in = recording.frame(i);
    in.stamp = stamp += from_seconds(0.125);
    return slam->track(frame_of(in)).value();
  };
  for (int i = 0; i <= 60; ++i) {
    const FrameResult result = show(i);
    ASSERT_TRUE(result.tracked()) << i;
    EXPECT_FALSE(result.tentative) << i;
  }
  FrameResult result;
  int i = 20;
  while (i < 30 && !result.tracked()) result = show(i++);
  EXPECT_TRUE(result.tracked());
  EXPECT_TRUE(result.tentative);
  for (const int end = i + 10; i < end; ++i) result = show(i);
  EXPECT_TRUE(result.tracked());
  EXPECT_FALSE(result.tentative);
}

}  // namespace
}  // namespace covis
