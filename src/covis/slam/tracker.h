// SPDX-License-Identifier: Apache-2.0
// Tracking: the pose of every frame against the map. Synchronous and without locks of its own: it reads the map in
// short read guards, works on copies, and asks for key frames by returning requests. Source: Mur-Artal, Montiel,
// Tardós, "ORB-SLAM", T-RO 2015, section V; Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, III.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "covis/map/shared_map.h"
#include "covis/matching/projection_match.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/slam/local_map.h"
#include "covis/slam/messages.h"
#include "covis/slam/mono_initializer.h"
#include "covis/slam/options.h"
#include "covis/slam/track_result.h"

namespace covis {

// What is known of a feature's place.
inline constexpr uint8_t kNone = 0;
inline constexpr uint8_t kMapPoint = 1;
inline constexpr uint8_t kTemporary = 2;  // from the frame's own depth, good for one frame

// The tracker's knowledge of one frame.
struct TrackedFrame {
  int64_t index = -1;
  Timestamp stamp = 0;
  FeaturesPtr features;
  SE3 T_cw;
  std::vector<MapPointId> points;          // for each feature its map point, or an invalid handle
  std::vector<Eigen::Vector3d> positions;  // for each feature, world; where known[i]
  std::vector<uint8_t> known;              // kNone, kMapPoint or kTemporary

  void start(FeaturesPtr f, int64_t frame, Timestamp t);
  int map_points() const;  // features with a map point
};

class Tracker {
 public:
  // Without a vocabulary (null) a lost camera is looked for at the nearest key frames only.
  Tracker(const SharedMap& map, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary = nullptr);

  // What should be done after a frame; at most one of the requests is set.
  struct Outcome {
    TrackResult result;
    std::optional<KeyFrameRequest> key_frame;
    std::optional<InitialMapRequest> initial_map;
    std::optional<int64_t> retract_from;   // frames from this one on had poses at a place that proves wrong
    std::optional<uint32_t> discard_submap;  // a monocular map was lost in its first moments: forget this submap
  };

  // Tracks one frame. map_is_live: the map may be read now; otherwise (mapping works on a key frame whose result is not
  // to be seen yet) the copies of the last live frame serve. mapping_idle: a key frame would be taken up at once.
  Outcome track(FeaturesPtr features, int64_t frame, Timestamp stamp, bool map_is_live, bool mapping_idle);

  // Mapping answered: key frames and points may have moved, merged or gone. Call before the next track().
  void key_frame_made(const KeyFrameMade& report);

  // The pose of one image in the map, from nothing: its T_cw and submap, or nothing when its place is not
  // recognised. Leaves the state of tracking aside: use a tracker of its own for it.
  struct Located {
    SE3 T_cw;
    uint32_t submap = 0;
  };
  std::optional<Located> locate(FeaturesPtr features, int64_t frame);
  // The frames are of another camera than the map: only for localisation in it.
  void use_camera(const Pinhole& camera) { own_camera_ = camera_ = camera; }
  // The map was changed beside mapping.
  void map_moved() { map_changed_ = true; }
  // A map was put in place that this tracker knows nothing of: the camera is to be found in it.
  void start_lost();

  // Whether the next frame should get twice the features: for the monocular initialiser, and while tracking hangs on
  // few points or is lost.
  bool wants_more_features() const {
    return state_ == TrackState::not_initialised ? monocular() : weak_ || (beginning_ && monocular());
  }
  // Whether the last frame had so few points that the next should have all that mapping can give.
  bool near_loss() const { return near_loss_; }
  TrackState state() const { return state_; }
  // Submaps of the map below this number were put in place: they are never given up.
  uint32_t kept_submaps() const { return kept_submaps_; }

 private:
  void initialise(Outcome& outcome);
  void initialise_with_depth(Outcome& outcome);
  void initialise_monocular(Outcome& outcome);
  void begin_map(TrackResult& result);

  bool find_pose(TrackResult& result, bool map_is_live);
  bool track_by_motion(TrackResult& result);
  bool track_by_reference(TrackResult& result);
  bool track_local_map(TrackResult& result, bool map_is_live);
  bool recover(TrackResult& result, bool map_is_live);
  std::vector<KeyFrameId> recovery_candidates(const Map& map);
  bool recover_from(const KeyFrameView& view, TrackResult& result, bool map_is_live);
  bool is_right_place(bool map_is_live, bool recovered);
  bool well_determined() const;
  void take_back_jump();  // when there was one: it led to a wrong place
  bool jumped() const;
  bool looks_as_usual(const Map& map, bool tentative);
  // Localisation only: whether the last frame's depth carries the pose over a place the map has too little, or nothing,
  // of.
  bool bridge(TrackResult& result);
  bool may_bridge() const { return options_.localize && !monocular(); }
  void accept(TrackResult& result);
  void lose(Outcome& outcome, bool map_is_live);
  // The present submap when, monocular and in its first moments, it is not worth keeping.
  std::optional<uint32_t> young_submap() const;
  bool new_map_due() const;

  void refresh_camera(const Map& map) { camera_ = own_camera_.value_or(map.camera()); }
  void refresh_last_frame(const Map& map);
  void set_reference(const Map& map, KeyFrameId key_frame);
  void take_over_points(const Map& map, KeyFrameId key_frame);
  void add_temporary_points();
  const std::vector<uint32_t>& near_features(const TrackedFrame& frame);

  // Makes the local map anew round the current frame's matches.
  void update_local_map(KeyFrameId fallback);
  std::optional<SE3> expected_motion() const;  // from the last camera to the current one
  // Searches set the matches of the current frame and return how many there are, or how many points were in view.
  int search_last_frame(double window);
  int match_key_frame(const KeyFrameView& view, double ratio, int max_distance);
  int search_local_map(double window_factor);
  void mark_matched();  // for matched(): the map points the current frame has now
  bool matched(MapPointId id) const {
    return id.slot < matched_mark_.size() && matched_mark_[id.slot] == matched_epoch_;
  }
  void set_match(size_t feature, MapPointId point, const Eigen::Vector3d& position_w, uint8_t known);
  // Optimises the current frame's pose over its matches and drops those that disagree; returns how many map points are
  // left, 0 when there is no pose.
  int optimize();
  double mean_depth() const;  // of the current frame's map points; 0: none
  // Whether something was within the last second.
  bool lately(Timestamp stamp) const { return current_.stamp - stamp < from_seconds(1.0); }
  int all_inliers() const;  // of the last optimize(), temporary points among them

  // From the reference key frame's view, so far that places in between would be seen by too few key frames.
  bool turned_away() const;
  bool key_frame_due(const TrackResult& result, bool mapping_idle) const;
  KeyFrameRequest make_key_frame_request();
  void count_points();
  void clear_counts();
  bool monocular() const { return options_.sensor == Sensor::monocular; }
  double close_depth() const;

  const SharedMap& map_;
  const SystemOptions options_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  TrackState state_ = TrackState::not_initialised;
  MonoInitializer initializer_;
  std::optional<Pinhole> own_camera_;
  Pinhole camera_;  // of the frames: the map's when it was read last

  TrackedFrame current_, last_;
  bool has_velocity_ = false;
  SE3 velocity_;                   // from the last camera to the current one …
  Timestamp velocity_time_ = 0;    // … in this time
  KeyFrameId reference_;           // the key frame poses are relative to
  double reference_scale_ = 1;     // KeyFrame::scale of it when last seen
  uint32_t submap_ = 0;              // of the map, to which it belongs
  SE3 last_T_cr_;                  // last frame relative to it
  std::optional<SE3> last_place_;  // T_cw of the last frame that had a pose, unless that was taken back
  KeyFrameId new_reference_;       // a key frame just made, to become the reference
  bool map_changed_ = false;       // since the last frame was refreshed
  uint64_t moves_ = 0;             // Map::moves() when it was
  LocalMap local_map_;
  int64_t begun_frame_ = -1;  // the last frame that asked for a map to be begun
  Timestamp last_key_frame_stamp_ = 0;
  Timestamp last_recovery_ = std::numeric_limits<Timestamp>::min() / 2;
  // The frame with which it jumped to where it is, until it has been there for a second: a tentative place.
  struct Jump {
    Timestamp stamp = 0;
    int64_t frame = 0;
  };
  std::optional<Jump> jumped_at_;
  std::optional<int64_t> retract_from_;  // Outcome::retract_from, to be told with this frame
  int lost_frames_ = 0;
  std::optional<Timestamp> lost_since_;
  bool beginning_ = false;  // lost for long: a new map is to be begun beside the old one
  int dead_reckoned_frames_ = 0;  // in a row
  bool weak_ = false;       // few inliers lately
  bool near_loss_ = false;  // few with the last frame
  uint32_t kept_submaps_ = 0;
  size_t recovery_cursor_ = 0;  // whose turn it is among all key frames

  std::vector<PointCount> counts_;  // by point slot
  std::vector<uint32_t> counted_;   // slots with something to tell

  // Scratch, kept so that tracking does not allocate.
  ProjectionMatcher projection_;
  WindowMatcher matcher_;
  std::vector<WindowQuery> queries_;
  std::vector<int32_t> query_source_;  // for each query, the last frame's feature or the local map's point
  std::vector<int32_t> match_;         // for each query
  std::vector<int32_t> matched_query_;
  std::vector<float> angle_a_, angle_b_;
  std::vector<uint8_t> keep_;
  std::vector<uint8_t> taken_;    // features that have a map point
  std::vector<uint8_t> known_;    // for each local point
  std::vector<MapPointId> matched_;
  std::vector<uint32_t> matched_mark_;  // by point slot: the epoch of mark_matched()
  uint32_t matched_epoch_ = 0;
  PoseObservations observations_;
  Matrix6d information_ = Matrix6d::Zero();  // of the last optimize()
  std::vector<int32_t> observed_feature_;
  std::vector<uint32_t> near_;
  std::vector<uint8_t> inlier_;
};

}  // namespace covis
