// SPDX-License-Identifier: Apache-2.0
// A place that may be where the current key frame is, copied out of the map, so that it is judged without the map.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "covis/geometry/sim3.h"
#include "covis/loops/loop_report.h"
#include "covis/map/key_frame_view.h"
#include "covis/matching/point_set.h"

namespace covis {

// A key frame and those around it, copied out of the map.
struct LoopPlace {
  KeyFrameId key_frame;
  SE3 T_cw;
  std::vector<KeyFrameId> group;  // the key frame first
  PointSet points;                // those the group observes, in the order of handles

  LoopPlace() = default;
  LoopPlace(const Map& map, KeyFrameId id);
};

// The way along the key frames of a submap.
struct Travel {
  double length = 0;  // in the map's unit
  double turned = 0;  // radians

  // How far what is at this depth moved past the camera.
  double past(double depth) const { return length + depth * turned; }
};

enum class LoopRelation { same_submap, other_submap };

// Everything that verification reads of the map.
struct LoopCandidate {
  Pinhole camera;
  int64_t frame = 0;  // index of the current key frame's frame in the recording
  KeyFrameView current;
  LoopPlace place;
  LoopRelation relation = LoopRelation::same_submap;  // the place lies in the same submap, or in another
  std::vector<KeyFrameView> members;                  // the first of the place's group
  std::vector<KeyFrameView> neighbours;               // the current key frame's best
  LoopPlace here;                                     // around the current key frame
  Travel travel;                                      // since the place; same_submap alone

  // Both key frames must live.
  LoopCandidate(const Map& map, KeyFrameId current, KeyFrameId place);
};

// A candidate as it was verified.
struct Loop {
  LoopPlace place;
  LoopRelation relation = LoopRelation::same_submap;
  Sim3 S_cw;                                             // the current key frame as the old place's map would have it
  std::vector<std::pair<uint32_t, MapPointId>> matches;  // feature of the current key frame, point of the place
  LoopDrift drift = {};                                  // as its points alone have it
  // By the pixels of all views, at S_cw or near it; none where they do not agree.
  std::optional<Matrix7d> information = {};
};

// The median depth of the points found again, in the unit of the place's map.
double median_depth(const Loop& loop);

// That between the key frames of two serials.
Travel travel_between(const Map& map, uint32_t submap, uint32_t serial_a, uint32_t serial_b);

}  // namespace covis
