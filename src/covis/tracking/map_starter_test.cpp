// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/map_starter.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

using Step = MapStarter::Step;

class MapStarterTest : public testing::Test {
 protected:
  static MapStarter::Settings settings_of(Sensor sensor) {
    MapStarter::Settings settings;
    settings.sensor = sensor;
    settings.options.init_features = 100;
    settings.options.new_map_after = 2;
    return settings;
  }
  // A map of the scene that this sensor made.
  std::unique_ptr<SceneMap> map_of(Sensor sensor, size_t key_frames) const {
    auto world = std::make_unique<SceneMap>(scene, sensor);
    world->add_key_frames(key_frames);
    return world;
  }

  const PointScene scene = PointScene::wall();
};

// ---- How a submap begins ----

TEST_F(MapStarterTest, AFrameWithDepthBeginsASubmapAtOnce) {
  MapStarter starter(settings_of(Sensor::rgbd));
  TrackedFrame frame = frame_of(scene.view(SE3()), SE3(), 5, 50);
  frame.set_match(3, {1, 0}, {}, PointSource::map);  // a match with an older submap
  const MapStarter::Offer offer = starter.offer(frame, scene.camera);
  const auto* request = std::get_if<KeyFrameRequest>(&offer.request);
  ASSERT_TRUE(request) << describe(offer.reason);
  EXPECT_EQ(offer.reason, NoPoseReason::none);
  EXPECT_EQ(request->frame, 5);
  EXPECT_EQ(request->stamp, 50);
  EXPECT_FALSE(request->pose.key_frame.valid()) << "relative to nothing there is";
  EXPECT_EQ(request->new_points.size(), frame.source.size());
  for (const MapPointId id : request->points) EXPECT_FALSE(id.valid());
  EXPECT_TRUE(starter.begun_with(5));
  EXPECT_FALSE(starter.begun_with(4));
}

TEST_F(MapStarterTest, FeaturesWithoutDepthMakeNoPoints) {
  MapStarter starter(settings_of(Sensor::stereo));
  const PointScene::View view = edited(scene.view(SE3()), [](Features& f) { f.depth[4] = 0; });
  const MapStarter::Offer offer = starter.offer(frame_of(view, SE3()), scene.camera);
  const auto* request = std::get_if<KeyFrameRequest>(&offer.request);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->new_points.size() + 1, view.point.size());
  EXPECT_EQ(std::count(request->new_points.begin(), request->new_points.end(), 4u), 0);
}

TEST_F(MapStarterTest, SaysWhyAFrameWithDepthIsNoBeginning) {
  MapStarter::Settings settings = settings_of(Sensor::rgbd);
  const PointScene::View view = scene.view(SE3());
  settings.options.init_features = static_cast<int>(view.point.size()) + 1;
  MapStarter demanding(settings);
  MapStarter::Offer offer = demanding.offer(frame_of(view, SE3(), 7), scene.camera);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(offer.request));
  EXPECT_EQ(offer.reason, NoPoseReason::few_features);
  EXPECT_FALSE(demanding.begun_with(7));

  MapStarter starter(settings_of(Sensor::rgbd));
  const PointScene::View flat = edited(view, [](Features& f) { std::fill(f.depth.begin() + 99, f.depth.end(), 0.0f); });
  offer = starter.offer(frame_of(flat, SE3(), 7), scene.camera);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(offer.request));
  EXPECT_EQ(offer.reason, NoPoseReason::few_features_with_depth);
}

TEST_F(MapStarterTest, OneEyeBeginsWithTwoViews) {
  MapStarter starter(settings_of(Sensor::monocular));
  const auto offer = [&](size_t step, int64_t frame) {
    return starter.offer(frame_of(scene.view(scene.T_cw(step), Sensor::monocular), SE3(), frame), scene.camera);
  };
  MapStarter::Offer made = offer(0, 3);
  EXPECT_EQ(made.reason, NoPoseReason::waiting_for_parallax);
  made = offer(0, 4);
  EXPECT_EQ(made.reason, NoPoseReason::low_parallax);
  EXPECT_GT(made.matches, 100);
  EXPECT_FALSE(starter.begun_with(4));
  made = offer(2, 5);
  const auto* request = std::get_if<InitialMapRequest>(&made.request);
  ASSERT_TRUE(request) << describe(made.reason);
  EXPECT_EQ(request->first.frame, 3);
  EXPECT_TRUE(starter.begun_with(5));
  EXPECT_EQ(offer(2, 6).reason, NoPoseReason::waiting_for_parallax) << "the next submap has a first view of its own";
}

// ---- What is done about a lost camera ----

TEST_F(MapStarterTest, AYoungMonocularSubmapIsReplacedOrGivenUpAfterFifteenFrames) {
  const auto world = map_of(Sensor::monocular, 5);
  MapStarter starter(settings_of(Sensor::monocular));
  for (int i = 0; i < 15; ++i)
    EXPECT_EQ(starter.lose(from_seconds(i), world->frames[1], &world->shared).step, Step::replace_submap) << i;
  const MapStarter::Loss loss = starter.lose(from_seconds(15), world->frames[1], &world->shared);
  EXPECT_EQ(loss.step, Step::give_up_submap);
  EXPECT_EQ(loss.submap, 0u);
  EXPECT_FALSE(starter.is_beginning()) << "there is no other: all begins anew";
}

TEST_F(MapStarterTest, FoundInTimeItIsSearchedAnew) {
  const auto world = map_of(Sensor::monocular, 5);
  MapStarter starter(settings_of(Sensor::monocular));
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 15; ++i)
      EXPECT_EQ(starter.lose(from_seconds(i), world->frames[1], &world->shared).step, Step::replace_submap);
    starter.accept(MapStarter::Place::settled);
  }
}

TEST_F(MapStarterTest, BesideOthersTheNextBeginsWhereAYoungOneIsGivenUp) {
  const auto world = map_of(Sensor::monocular, 8);
  KeyFrameId young;
  {
    const auto map = world->shared.write();
    young = map->begin_submap(50, 50, SE3(), world->views[0].features);
  }
  MapStarter starter(settings_of(Sensor::monocular));
  MapStarter::Loss loss;
  for (int i = 0; i < 16; ++i) loss = starter.lose(from_seconds(i), young, &world->shared);
  EXPECT_EQ(loss.step, Step::give_up_submap);
  EXPECT_EQ(loss.submap, 1u);
  EXPECT_TRUE(starter.is_beginning());
}

TEST_F(MapStarterTest, GrownSubmapsAreKept) {
  const auto world = map_of(Sensor::monocular, 6);
  MapStarter::Settings settings = settings_of(Sensor::monocular);
  settings.begins_new_maps = false;
  MapStarter starter(settings);
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(starter.lose(from_seconds(i), world->frames[1], &world->shared).step, Step::search);
}

TEST_F(MapStarterTest, SubmapsPutInPlaceAreKeptHoweverYoung) {
  const auto world = map_of(Sensor::monocular, 2);
  MapStarter::Settings settings = settings_of(Sensor::monocular);
  settings.begins_new_maps = false;
  MapStarter starter(settings);
  starter.keep_submaps(*world->shared.read());
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(starter.lose(from_seconds(i), world->frames[1], &world->shared).step, Step::search);
  starter.keep_submaps(Map());
  EXPECT_EQ(starter.lose(from_seconds(100), world->frames[1], &world->shared).step, Step::give_up_submap);
}

class LostForLongTest : public MapStarterTest {
 protected:
  Step lose_at(MapStarter& starter, double seconds) const {
    return starter.lose(from_seconds(seconds), world->frames[1], &world->shared).step;
  }

  const std::unique_ptr<SceneMap> world = map_of(Sensor::rgbd, 2);
};

TEST_F(LostForLongTest, AfterTwoSecondsANewSubmapIsBegun) {
  MapStarter starter(settings_of(Sensor::rgbd));
  EXPECT_EQ(lose_at(starter, 10), Step::search);
  EXPECT_EQ(lose_at(starter, 11.9), Step::search);
  EXPECT_FALSE(starter.is_beginning());
  EXPECT_EQ(lose_at(starter, 12), Step::begin_submap);
  EXPECT_TRUE(starter.is_beginning());
  EXPECT_EQ(lose_at(starter, 12.1), Step::begin_submap) << "with whatever frame is good for it";
  starter.begun();
  EXPECT_FALSE(starter.is_beginning());
  EXPECT_EQ(lose_at(starter, 12.2), Step::search) << "the time counts anew";
  EXPECT_EQ(lose_at(starter, 14.2), Step::begin_submap);
}

TEST_F(LostForLongTest, FoundMeanwhileTheTimeCountsAnew) {
  MapStarter starter(settings_of(Sensor::rgbd));
  EXPECT_EQ(lose_at(starter, 10), Step::search);
  starter.accept(MapStarter::Place::settled);
  EXPECT_EQ(lose_at(starter, 13), Step::search);
  EXPECT_EQ(lose_at(starter, 15), Step::begin_submap);
  starter.accept(MapStarter::Place::settled);
  EXPECT_FALSE(starter.is_beginning());
}

TEST_F(LostForLongTest, ATentativePlaceDoesNotStopTheTime) {
  MapStarter starter(settings_of(Sensor::rgbd));
  EXPECT_EQ(lose_at(starter, 10), Step::search);
  starter.accept(MapStarter::Place::tentative);
  EXPECT_EQ(lose_at(starter, 12), Step::begin_submap) << "the place proved wrong: it was lost all the time";
}

TEST_F(LostForLongTest, ALossIsCountedFromWhenNothingWasSeenAnyMore) {
  MapStarter starter(settings_of(Sensor::rgbd));
  starter.note_loss(from_seconds(8));
  for (const double seconds : {10.0, 10.1}) EXPECT_EQ(lose_at(starter, seconds), Step::search) << "it is looked for";
  EXPECT_EQ(lose_at(starter, 10.2), Step::begin_submap) << "no frame came for two seconds before";
  starter.begun();
  EXPECT_EQ(lose_at(starter, 20), Step::search);
  starter.note_loss(from_seconds(18));
  EXPECT_EQ(lose_at(starter, 21), Step::search) << "it is lost since 20";
}

TEST_F(LostForLongTest, NoneIsBegunThatCouldNeverBeJoined) {
  MapStarter::Settings settings = settings_of(Sensor::rgbd);
  settings.begins_new_maps = false;
  MapStarter starter(settings);
  for (const double seconds : {10.0, 20.0, 1000.0}) EXPECT_EQ(lose_at(starter, seconds), Step::search);
}

TEST_F(LostForLongTest, NoneIsBegunWhenTheTimeIsSetToNever) {
  MapStarter::Settings settings = settings_of(Sensor::rgbd);
  settings.options.new_map_after = 0;
  MapStarter starter(settings);
  for (const double seconds : {10.0, 20.0, 1000.0}) EXPECT_EQ(lose_at(starter, seconds), Step::search);
}

TEST_F(LostForLongTest, WhileTheMapIsHiddenItIsSearched) {
  MapStarter starter(settings_of(Sensor::rgbd));
  EXPECT_EQ(starter.lose(from_seconds(10), world->frames[1], nullptr).step, Step::search);
  EXPECT_EQ(starter.lose(from_seconds(20), world->frames[1], nullptr).step, Step::search);
  EXPECT_EQ(lose_at(starter, 20), Step::begin_submap) << "the time went on";
}

TEST_F(LostForLongTest, ACameraThatWasNeverInTheMapBeginsBesideItToo) {
  MapStarter starter(settings_of(Sensor::rgbd));
  EXPECT_EQ(starter.lose(from_seconds(0), {}, &world->shared).step, Step::search);
  EXPECT_EQ(starter.lose(from_seconds(2), {}, &world->shared).step, Step::begin_submap);
}

TEST_F(MapStarterTest, OnlyAYoungMonocularSubmapMayBeGivenUp) {
  for (const Sensor sensor : {Sensor::monocular, Sensor::rgbd}) {
    const MapStarter starter(settings_of(sensor));
    const auto young = map_of(sensor, 5), old = map_of(sensor, 6);
    const bool monocular = sensor == Sensor::monocular;
    EXPECT_EQ(starter.may_give_up(&young->shared, young->frames.front()), monocular);
    EXPECT_FALSE(starter.may_give_up(&old->shared, old->frames.front()));
    EXPECT_EQ(starter.may_give_up(nullptr, old->frames.front()), monocular) << "the map may not be read";
  }
}

}  // namespace
}  // namespace covis
