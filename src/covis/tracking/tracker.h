// SPDX-License-Identifier: Apache-2.0
// Tracking: the pose of every frame against the map. Synchronous and without locks of its own: it reads the map in
// short read guards, works on copies, and asks for key frames by returning requests. Its parts, each with a header:
//
//   MotionModel     predicts where the camera is
//   FirstPose       finds the first pose, by hypotheses that compete
//   MatchBelief     judges whether a pose explains what the camera sees
//   FrameMatcher    searches for known points, and finds the pose that they agree on
//   LocalMap        the points around the camera, copied out of the map
//   PlaceCheck      judges whether that is the place it claims to be
//   KeyFramePolicy  decides when a frame becomes a key frame
//   Relocaliser     finds a lost camera
//   MapStarter      begins submaps, and gives young ones up
//   DepthBelief     judges whether depth contradicts the map, and for how long
//   Backlog         keeps frames without a pose, to be located afterwards
//
// Sources: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section V; Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017,
// III.
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "covis/core/schedule.h"
#include "covis/tracking/backlog.h"
#include "covis/tracking/depth_against_map.h"
#include "covis/tracking/first_pose.h"
#include "covis/tracking/key_frame_policy.h"
#include "covis/tracking/last_frame.h"
#include "covis/tracking/map_starter.h"
#include "covis/tracking/match_belief.h"
#include "covis/tracking/motion_model.h"
#include "covis/tracking/relocaliser.h"

namespace covis {

enum class TrackingMode {
  mapping,
  localisation,  // no key frames, no points: places with too few map points are dead-reckoned by the frames' depth
};

struct TrackingSettings {
  Sensor sensor = Sensor::monocular;
  TrackerOptions options;
  Schedule schedule = Schedule::deterministic;
  TrackingMode mode = TrackingMode::mapping;
  bool closes_loops = true;  // submaps can be joined: only then a second one is begun
  int seed = 0;
  ShutterOptions shutter;
  const ImageProbe* image = nullptr;  // looks at the image of the frame that is tracked; null: none is kept

  bool dead_reckons() const { return mode == TrackingMode::localisation && sensor != Sensor::monocular; }
};

// The state of mapping when a frame comes, and what else is known then.
struct MappingStatus {
  // hidden: there is a result that is not to be seen yet, and the copies of the last live frame serve.
  enum class Map { live, hidden };
  Map map = Map::live;
  MappingLoad load = MappingLoad::idle;
  // right: the motion of the images says so, of the last frames (DepthBelief::trust_depth()).
  enum class Depth { unknown, right };
  Depth depth = Depth::unknown;
};

class Tracker {
 public:
  // Without a vocabulary (null) a lost camera is looked for at the nearest key frames, and at few others in turn.
  Tracker(const SharedMap& map, const TrackingSettings& settings,
          std::shared_ptr<const Vocabulary> vocabulary = nullptr);

  // A frame's result, and the requests that follow from it.
  struct Outcome {
    TrackResult result;
    MapRequest request;
    std::optional<int64_t> retract_from;     // frames from this one on had poses at a place that proves wrong
    std::optional<uint32_t> discard_submap;  // a monocular submap was lost in its first moments: forget it
  };
  Outcome track(FeaturesPtr features, int64_t frame, Timestamp stamp, const MappingStatus& mapping);

  // Mapping answered: key frames and points may have moved, merged or gone. Call before the next track().
  void key_frame_made(const KeyFrameMade& made);
  // The map was changed beside mapping.
  void map_moved() { last_.map_changed = true; }
  // A map was put in place that this tracker knows nothing of: the camera is to be found in it.
  void start_lost();
  // Changes between mapping and localisation only. A pose that dead reckoning carried is given up when mapping begins:
  // the camera is to be found in the map first.
  void set_mode(TrackingMode mode);
  // The cameras, and the search of the last frame: its local map, and which points of it the frame should have shown.
  const PoseSearch& search() const { return search_; }

  // True when the next frame should get twice the features: for the monocular initialiser, and while tracking has few
  // points or is lost.
  bool wants_more_features() const;
  // True when the last frame had so few points that the next should have all that mapping can give.
  bool near_loss() const { return health_.near_loss; }
  TrackingState state() const { return state_; }
  // The last frame, with the points that it shows when it was tracked.
  const TrackedFrame& last_frame() const { return last_.frame; }
  // Frames without a pose before places where the camera was found, newest first, for backtrack(): at the end, when no
  // key frame takes them along. None while the last of these places is tentative. Those whose place is sure are given
  // once.
  std::vector<UnlocatedFrame> take_unlocated() {
    return search_.place.tentative() ? std::vector<UnlocatedFrame>() : backlog_.take_with_found();
  }

 private:
  bool find_pose(TrackResult& result, const SharedMap* live);
  bool find_first_pose(TrackResult& result);
  bool track_local_map(TrackResult& result, const SharedMap* live);
  bool dead_reckon(TrackResult& result);
  bool relocalise(TrackResult& result, const SharedMap* live, std::optional<uint32_t> but = {});
  void accept(TrackResult& result);
  void lose(Outcome& outcome, const SharedMap* live);
  void begin_submap(Outcome& outcome);

  void follow_map(const Map& map);

  // The signs of how safely the camera is tracked.
  struct Health {
    Timestamp last_recovery = std::numeric_limits<Timestamp>::min() / 2;
    int dead_reckoned_frames = 0;  // number in a row
    bool weak = false;             // few inliers lately
    bool near_loss = false;        // few with the last frame
    bool leaves_map = false;  // depth says that the map is wrong: the camera is to be found in another, or begins one

    static constexpr double kLately = 1.0;  // seconds
    bool recovered_lately(Timestamp now) const { return now - last_recovery < from_seconds(kLately); }
  };

  const SharedMap& map_;
  TrackingSettings settings_;
  TrackingState state_ = TrackingState::not_initialised;
  TrackedFrame current_;
  LastFrame last_;
  Health health_;
  PoseSearch search_;
  MotionModel motion_;
  FirstPose first_pose_;
  MatchBelief belief_;
  KeyFramePolicy key_frames_;
  MapStarter starter_;
  Relocaliser relocaliser_;
  DepthBelief depth_;
  Backlog backlog_;
};

}  // namespace covis
