// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/map_starter.h"

#include <utility>

#include "covis/core/log.h"

namespace covis {

MapStarter::MapStarter(const Settings& settings) : settings_(settings), initializer_(settings.options, settings.seed) {}

MapStarter::Offer MapStarter::offer(const TrackedFrame& frame, const Pinhole& camera) {
  Offer offer;
  if (settings_.sensor != Sensor::monocular) {
    offer = offer_with_depth(frame);
  } else {
    auto initial_map = initializer_.offer(camera, frame.features, frame.index, frame.stamp);
    offer.matches = initializer_.matches();
    if (initial_map) {
      initializer_.reset();
      offer.request = std::move(*initial_map);
    } else {
      offer.reason = initializer_.reason();
    }
  }
  if (!std::holds_alternative<std::monostate>(offer.request)) begun_frame_ = frame.index;
  return offer;
}

MapStarter::Offer MapStarter::offer_with_depth(const TrackedFrame& frame) const {
  const Features& f = *frame.features;
  if (f.size() < settings_.options.init_features) return {{}, NoPoseReason::few_features};
  KeyFrameRequest request = frame.request();
  for (uint32_t i = 0; i < static_cast<uint32_t>(f.size()); ++i) {
    if (f.depth[i] > 0) request.new_points.push_back(i);
  }
  if (static_cast<int>(request.new_points.size()) < settings_.min_close_points)
    return {{}, NoPoseReason::few_features_with_depth};
  return {std::move(request), {}};
}

void MapStarter::begun() {
  beginning_ = false;
  lost_since_.reset();
  untried_ = false;
  lost_frames_ = 0;
}

void MapStarter::accept(Place place) {
  if (lost_frames_ > 0) initializer_.reset();  // the next submap has a first view of its own
  lost_frames_ = 0;
  beginning_ = false;
  if (place == Place::tentative) return;
  lost_since_.reset();
  untried_ = false;
}

MapStarter::Loss MapStarter::lose(Timestamp stamp, KeyFrameId reference, const SharedMap* live) {
  constexpr int kYoungPatience = 15;  // frames that a young submap is searched for the camera
  ++lost_frames_;
  if (!lost_since_) lost_since_ = stamp;
  if (!live) return {};
  std::optional<uint32_t> young;
  bool has_others = false;
  {
    const auto map = live->read();
    young = young_submap(*map, reference);
    has_others = map->submaps().size() > 1;
  }
  if (young) {
    beginning_ = has_others;
    if (lost_frames_ <= kYoungPatience) return {Step::replace_submap, *young};
    lost_frames_ = 0;
    return {Step::give_up_submap, *young};
  }
  if (!beginning_ && !new_map_due(stamp)) return {};
  if (!beginning_) {
    log(LogLevel::warning, reference.valid() ? "lost for long: a new map is begun beside the old one"
                                             : "the loaded map is not found: a new one is begun beside it");
  }
  beginning_ = true;
  return {Step::begin_submap};
}

void MapStarter::keep_submaps(const Map& map) { kept_submaps_ = map.next_submap(); }

// The submap of the reference key frame when, monocular and in its first moments, it is not worth keeping.
std::optional<uint32_t> MapStarter::young_submap(const Map& map, KeyFrameId reference) const {
  constexpr size_t kYoung = 5;  // key frames
  if (settings_.sensor != Sensor::monocular) return std::nullopt;
  const auto resolved = map.resolve(reference);
  if (!resolved) return std::nullopt;
  const Submap& submap = *map.submap(map.at(resolved->key_frame).submap);
  if (submap.id < kept_submaps_ || submap.key_frames > kYoung) return std::nullopt;
  return submap.id;
}

bool MapStarter::new_map_due(Timestamp stamp) const {
  constexpr int kTries = 3;  // frames: the first one after a pause may be blurred
  if (untried_ && lost_frames_ < kTries) return false;
  return may_begin_beside() && stamp - *lost_since_ >= from_seconds(settings_.options.new_map_after);
}

}  // namespace covis
