// SPDX-License-Identifier: Apache-2.0
// The life of a submap as tracking sees it: how one begins (algorithms.md §3.6), that a monocular one lost in its first
// moments is given up, and that a camera lost for long begins another beside those there are.
#pragma once

#include <optional>
#include <variant>

#include "covis/map/map_requests.h"
#include "covis/map/shared_map.h"
#include "covis/tracking/mono_initializer.h"
#include "covis/tracking/tracked_frame.h"
#include "covis/tracking/tracking_options.h"
#include "covis/types.h"

namespace covis {

// The request to mapping after a frame, if there is one.
using MapRequest = std::variant<std::monostate, KeyFrameRequest, InitialMapRequest>;

class MapStarter {
 public:
  struct Settings {
    Sensor sensor = Sensor::monocular;
    StartOptions options;
    int min_close_points = 100;   // features with depth that a first key frame needs (stereo, RGB-D)
    bool begins_new_maps = true;  // a submap may be begun beside others
    int seed = 0;
  };
  explicit MapStarter(const Settings& settings);

  // Offers a frame to begin a submap with. Without a request `reason` says why it can't.
  struct Offer {
    MapRequest request;
    NoPoseReason reason = NoPoseReason::none;
    int matches = 0;  // matches of a monocular frame with the first view
  };
  Offer offer(const TrackedFrame& frame, const Pinhole& camera);
  // True when a submap was asked for with this frame.
  bool begun_with(int64_t frame) const { return frame == begun_frame_; }
  // A submap was begun.
  void begun();

  // The step to take when a frame is lost. Replace: the submap is given up if another can begin with this frame.
  enum class Step { search, give_up_submap, replace_submap, begin_submap };
  struct Loss {
    Step step = Step::search;
    uint32_t submap = 0;  // id of the submap to be given up or replaced
  };
  // `reference`: the last key frame the camera was at; `live`: null while the map may not be read.
  Loss lose(Timestamp stamp, KeyFrameId reference, const SharedMap* live);
  // A camera that is lost now has been lost since this moment, when no frame came any more, or when it came to a place
  // that proves wrong.
  void note_loss(Timestamp stamp) {
    if (lost_since_) return;
    lost_since_ = stamp;
    untried_ = true;
  }
  // True when a submap may be begun beside others.
  bool may_begin_beside() const { return settings_.begins_new_maps && settings_.options.new_map_after > 0; }
  // A frame has its pose. Settled: its place is not tentative.
  enum class Place { settled, tentative };
  void accept(Place place);
  // True when the submap of this key frame may be so young that it is given up if the camera is lost. `live`: null
  // while the map may not be read.
  bool may_give_up(const SharedMap* live, KeyFrameId reference) const {
    return settings_.sensor == Sensor::monocular && (!live || young_submap(*live->read(), reference));
  }
  // A map was put in place: its submaps are never given up.
  void keep_submaps(const Map& map);

  // True when the camera was lost for long, so that a submap is to be begun beside the others.
  bool is_beginning() const { return beginning_; }

 private:
  Offer offer_with_depth(const TrackedFrame& frame) const;
  std::optional<uint32_t> young_submap(const Map& map, KeyFrameId reference) const;
  bool new_map_due(Timestamp stamp) const;

  const Settings settings_;
  MonoInitializer initializer_;
  int64_t begun_frame_ = -1;  // the last frame that asked for a submap
  bool beginning_ = false;
  int lost_frames_ = 0;
  std::optional<Timestamp> lost_since_;
  bool untried_ = false;       // it was not looked for since then
  uint32_t kept_submaps_ = 0;  // submaps with lower ids were put in place
};

}  // namespace covis
