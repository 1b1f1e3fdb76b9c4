// SPDX-License-Identifier: Apache-2.0
#include "covis/api/events.h"

#include <utility>

namespace covis {
namespace {

using Kind = Event::Kind;

// A key frame that was erased meanwhile is nothing to tell of.
void tell_key_frame(KeyFrameId id, const Map& map, std::vector<Event>& events) {
  const KeyFrame* key_frame = map.find(id);
  if (!key_frame) return;
  events.push_back({.kind = Kind::key_frame_made,
                    .stamp = key_frame->stamp,
                    .submap = static_cast<int>(key_frame->submap),
                    .key_frame = key_frame->serial});
}

void tell_loop(const MappingReport& report, const Map& map, std::vector<Event>& events) {
  if (!report.loop.changed_map()) return;
  const KeyFrame *key_frame = map.find(report.key_frame), *place = map.find(report.loop.loop);
  Event event{.kind = report.loop.outcome == LoopOutcome::joined ? Kind::submaps_joined : Kind::loop_closed};
  if (place) {
    event.submap = static_cast<int>(place->submap);
    event.place = place->serial;
  }
  if (key_frame) {
    event.stamp = key_frame->stamp;
    event.submap = static_cast<int>(key_frame->submap);
    event.key_frame = key_frame->serial;
  }
  // The map knows what became of the key frames' submap since.
  if (report.loop.joined) {
    event.ended = static_cast<int>(report.loop.joined->id);
    event.submap = static_cast<int>(report.loop.joined->kept);
  }
  events.push_back(event);
}

}  // namespace

std::vector<Event> EventTeller::of_mapping(const std::vector<MappingReport>& reports, const SharedMap& map) {
  std::vector<Event> events;
  if (reports.empty()) return events;
  const auto guard = map.read();
  for (const MappingReport& report : reports) {
    tell_key_frame(report.first, *guard, events);
    tell_key_frame(report.key_frame, *guard, events);
    tell_loop(report, *guard, events);
  }
  return events;
}

void EventTeller::follow(const std::vector<Event>& joined) {
  for (const Event& event : joined) {
    if (event.ended == static_cast<int>(submap_)) submap_ = static_cast<uint32_t>(event.submap);
  }
}

std::vector<Event> EventTeller::of_end(int64_t stamp, const std::vector<MappingReport>& reports,
                                       const std::vector<SensorWarning>& warnings, const SharedMap& map) {
  std::vector<Event> events = of_mapping(reports, map);
  follow(events);
  if (!warnings.empty())
    events.push_back({.kind = Kind::sensor_doubted, .stamp = stamp, .submap = static_cast<int>(submap_)});
  return events;
}

std::vector<Event> EventTeller::of_frame(int64_t stamp, const FrameReport& report, const SharedMap& map) {
  const TrackResult& track = report.track;
  const bool tracked = track.state == TrackingState::tracking;
  const bool begun = tracked && track.method == TrackMethod::initialised;
  const TrackingState before = std::exchange(state_, track.state);
  std::vector<Event> events;
  const auto tell = [&](Kind kind, uint32_t submap) {
    events.push_back({.kind = kind, .stamp = stamp, .submap = static_cast<int>(submap), .reason = track.reason});
  };
  if (begun) tell(Kind::submap_begun, track.submap);
  const std::vector<Event> of_map = of_mapping(report.mapping, map);
  events.insert(events.end(), of_map.begin(), of_map.end());
  follow(of_map);
  if (report.discarded_submap) tell(Kind::submap_discarded, *report.discarded_submap);
  if (tracked && !begun && before == TrackingState::lost) tell(Kind::found, track.submap);
  if (!tracked && before == TrackingState::tracking) tell(Kind::lost, submap_);
  if (!report.warnings.empty()) tell(Kind::sensor_doubted, tracked ? track.submap : submap_);
  if (tracked) submap_ = track.submap;
  return events;
}

const char* name(Event::Kind kind) {
  switch (kind) {
    case Event::Kind::key_frame_made:
      return "key_frame_made";
    case Event::Kind::loop_closed:
      return "loop_closed";
    case Event::Kind::submaps_joined:
      return "submaps_joined";
    case Event::Kind::submap_begun:
      return "submap_begun";
    case Event::Kind::submap_discarded:
      return "submap_discarded";
    case Event::Kind::lost:
      return "lost";
    case Event::Kind::found:
      return "found";
    case Event::Kind::sensor_doubted:
      return "sensor_doubted";
  }
  return "";
}

}  // namespace covis
