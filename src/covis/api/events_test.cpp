// SPDX-License-Identifier: Apache-2.0
#include "covis/api/events.h"

#include <gtest/gtest.h>

#include "covis/map/test_map.h"

namespace covis {
namespace {

using Kind = Event::Kind;

// A map with three key frames; the reports name them.
class EventsTest : public testing::Test {
 protected:
  void SetUp() override {
    MapFixture made;
    a = made.frame(0);
    b = made.frame(1);
    c = made.frame(2);
    *shared.write() = std::move(made.map);
  }
  uint32_t serial(KeyFrameId id) const { return shared.read()->at(id).serial; }
  static MappingReport mapped(KeyFrameId key_frame) {
    MappingReport report;
    report.key_frame = key_frame;
    return report;
  }
  static std::vector<Kind> kinds(const std::vector<Event>& events) {
    std::vector<Kind> kinds;
    for (const Event& event : events) kinds.push_back(event.kind);
    return kinds;
  }
  std::vector<Kind> show(EventTeller& teller, TrackingState state, TrackMethod method = TrackMethod::motion_model) {
    FrameReport report;
    report.track.state = state;
    report.track.method = method;
    return kinds(teller.of_frame(stamp_ += 10, report, shared));
  }

  KeyFrameId a, b, c;
  SharedMap shared;

 private:
  int64_t stamp_ = 0;
};

TEST_F(EventsTest, KeyFramesOfAnInitialMapAreToldInTheirOrder) {
  MappingReport report = mapped(b);
  report.first = a;
  const auto events = EventTeller::of_mapping({report}, shared);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].key_frame, serial(a));
  EXPECT_EQ(events[1].key_frame, serial(b));
  EXPECT_EQ(events[1].stamp, shared.read()->at(b).stamp);
}

TEST_F(EventsTest, AKeyFrameThatWasRefusedIsNotTold) {
  EXPECT_TRUE(EventTeller::of_mapping({mapped({})}, shared).empty());
  EXPECT_TRUE(EventTeller::of_mapping({}, shared).empty());
}

TEST_F(EventsTest, ALoopNamesBothKeyFrames) {
  for (const auto& [outcome, kind] :
       {std::pair{LoopOutcome::closed, Kind::loop_closed}, std::pair{LoopOutcome::joined, Kind::submaps_joined}}) {
    MappingReport report = mapped(c);
    report.loop.outcome = outcome;
    report.loop.loop = a;
    if (outcome == LoopOutcome::joined) report.loop.joined = JoinedSubmap{3, 0, 7};
    const auto events = EventTeller::of_mapping({report}, shared);
    EXPECT_EQ(kinds(events), (std::vector{Kind::key_frame_made, kind}));
    EXPECT_EQ(events[1].key_frame, serial(c));
    EXPECT_EQ(events[1].place, serial(a));
    EXPECT_EQ(events[1].ended, outcome == LoopOutcome::joined ? std::optional(3) : std::nullopt);
  }
  MappingReport fused = mapped(c);
  fused.loop.outcome = LoopOutcome::fused;
  EXPECT_EQ(EventTeller::of_mapping({fused}, shared).size(), 1u) << "no pose has moved";
}

TEST_F(EventsTest, LossesAndFindsAreToldOnce) {
  EventTeller teller(TrackingState::not_initialised);
  using S = TrackingState;
  EXPECT_TRUE(show(teller, S::not_initialised).empty());
  EXPECT_EQ(show(teller, S::tracking, TrackMethod::initialised), std::vector{Kind::submap_begun});
  EXPECT_TRUE(show(teller, S::tracking).empty());
  EXPECT_EQ(show(teller, S::lost), std::vector{Kind::lost});
  EXPECT_TRUE(show(teller, S::lost).empty());
  EXPECT_EQ(show(teller, S::tracking, TrackMethod::recovered), std::vector{Kind::found});
  EXPECT_EQ(show(teller, S::lost), std::vector{Kind::lost});
  EXPECT_EQ(show(teller, S::tracking, TrackMethod::initialised), std::vector{Kind::submap_begun})
      << "the camera was not found: it is in a submap of its own";

  EventTeller loaded(TrackingState::lost);
  EXPECT_EQ(show(loaded, S::tracking, TrackMethod::recovered), std::vector{Kind::found});
}

TEST_F(EventsTest, ALossNamesTheSubmapTheCameraWasIn) {
  EventTeller teller(TrackingState::not_initialised);
  FrameReport report;
  report.track.state = TrackingState::tracking;
  report.track.submap = 4;
  teller.of_frame(10, report, shared);
  report.track.state = TrackingState::lost;
  report.track.submap = 0;
  const auto events = teller.of_frame(20, report, shared);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].submap, 4);
}

TEST_F(EventsTest, ASubmapBeginsBeforeItsKeyFrames) {
  EventTeller teller(TrackingState::not_initialised);
  FrameReport report;
  report.track.state = TrackingState::tracking;
  report.track.method = TrackMethod::initialised;
  report.mapping.push_back(mapped(a));
  EXPECT_EQ(kinds(teller.of_frame(10, report, shared)), (std::vector{Kind::submap_begun, Kind::key_frame_made}));
}

TEST_F(EventsTest, ASubmapGivenUpIsTold) {
  EventTeller teller(TrackingState::tracking);
  FrameReport report;
  report.track.state = TrackingState::not_initialised;
  report.track.reason = NoPoseReason::few_map_points_agree;
  report.discarded_submap = 3;
  const auto events = teller.of_frame(70, report, shared);
  EXPECT_EQ(kinds(events), (std::vector{Kind::submap_discarded, Kind::lost}));
  EXPECT_EQ(events[0].submap, 3);
  EXPECT_EQ(events[1].reason, NoPoseReason::few_map_points_agree);
  EXPECT_EQ(events[1].stamp, 70);
}

TEST_F(EventsTest, DepthThatIsNonsenseIsTold) {
  EventTeller teller(TrackingState::tracking);
  FrameReport report;
  report.track.state = TrackingState::tracking;
  report.warnings.push_back({SensorDoubt::depth_against_motion, 1.2, 7});
  const auto events = teller.of_frame(70, report, shared);
  EXPECT_EQ(kinds(events), (std::vector{Kind::sensor_doubted}));
  EXPECT_EQ(events[0].stamp, 70);
}

TEST_F(EventsTest, DepthThatIsNonsenseIsToldAtTheEndToo) {
  EventTeller teller(TrackingState::tracking);
  EXPECT_TRUE(teller.of_end(80, {}, {}, shared).empty());
  const auto events = teller.of_end(80, {}, {{SensorDoubt::depth_against_motion, 1.2, 7}}, shared);
  EXPECT_EQ(kinds(events), (std::vector{Kind::sensor_doubted}));
  EXPECT_EQ(events[0].stamp, 80);
}

// A camera in submap 1, which is joined to the key frames' submap 0.
TEST_F(EventsTest, AfterAJoinTheCameraIsInTheSubmapThatRemains) {
  MappingReport joined = mapped(c);
  joined.loop.outcome = LoopOutcome::joined;
  joined.loop.loop = a;
  joined.loop.joined = JoinedSubmap{1, 0, 0};
  for (const bool at_the_end : {false, true}) {
    EventTeller teller(TrackingState::not_initialised);
    FrameReport report;
    report.track.state = TrackingState::tracking;
    report.track.submap = 1;
    teller.of_frame(10, report, shared);
    FrameReport lost;
    lost.track.state = TrackingState::lost;
    lost.warnings.emplace_back();
    if (at_the_end) {
      teller.of_end(10, {joined}, {}, shared);
    } else {
      lost.mapping = {joined};
    }
    const auto events = teller.of_frame(20, lost, shared);
    ASSERT_GE(events.size(), 2u);
    EXPECT_EQ(kinds({events.end() - 2, events.end()}), (std::vector{Kind::lost, Kind::sensor_doubted}));
    EXPECT_EQ(events.end()[-2].submap, 0);
    EXPECT_EQ(events.back().submap, 0);
  }
}

// Two joins in one call: 2 became a part of 1, and then 1 of 0.
TEST_F(EventsTest, AJoinTellsTheSubmapThatRemainedThen) {
  MappingReport first = mapped(c), second = mapped(c);
  for (MappingReport* report : {&first, &second}) {
    report->loop.outcome = LoopOutcome::joined;
    report->loop.loop = a;
  }
  first.loop.joined = JoinedSubmap{2, 1, 5};
  second.loop.joined = JoinedSubmap{1, 0, 7};
  std::vector<std::pair<int, int>> joins;
  for (const Event& event : EventTeller::of_mapping({first, second}, shared)) {
    if (event.ended) joins.emplace_back(*event.ended, event.submap);
  }
  EXPECT_EQ(joins, (std::vector<std::pair<int, int>>{{2, 1}, {1, 0}}));
}

TEST_F(EventsTest, ADoubtWhileTheCameraIsLostNamesItsLastSubmap) {
  EventTeller teller(TrackingState::not_initialised);
  FrameReport report;
  report.track.state = TrackingState::tracking;
  report.track.submap = 2;
  teller.of_frame(10, report, shared);
  report.track.state = TrackingState::lost;
  report.track.submap = 0;
  report.warnings.emplace_back();
  const auto events = teller.of_frame(20, report, shared);
  EXPECT_EQ(kinds(events), (std::vector{Kind::lost, Kind::sensor_doubted}));
  EXPECT_EQ(events.back().submap, 2);
}

}  // namespace
}  // namespace covis
