// SPDX-License-Identifier: Apache-2.0
// The map: key frames, map points and the graphs between them. Plain data without locks (architecture.md, decisions 1
// and 2); SharedMap (shared_map.h) puts the one lock around it. The map owns its things in slot stores; a stale handle
// finds nothing. Every invariant is kept by the methods here and tested by check(). Source: Mur-Artal, Montiel, Tardós,
// "ORB-SLAM", T-RO 2015, sections III-C and III-D; erasure: VI-E.
//
// It may have several submaps: what was mapped after the camera was lost in an unknown place stands beside the rest
// until the submaps are joined (the "Atlas" of Elvira, Tardós, Montiel, IROS 2019, within one container). Each submap
// has a world and a spanning tree of its own, and no point is seen from two submaps. A map made without a loss has one
// submap.
//
// All of it is expressed in one camera (camera_change.h): key frames hold pixels, the map the intrinsics, which may be
// refined as it grows.
//
// Units: metres. Frames: w the world, c a camera. All containers iterate in an order that depends on the operations
// alone, never on addresses.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/ids.h"
#include "covis/core/time.h"
#include "covis/features/features.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"
#include "covis/geometry/sim3.h"
#include "covis/map/colours.h"
#include "covis/map/key_frame_database.h"
#include "covis/map/slot_store.h"

namespace covis {

inline constexpr int kCovisibilityThreshold = 15;  // shared points that make an edge of the covisibility graph
inline constexpr int kEssentialThreshold = 100;    // shared points that make an edge of the essential graph

struct Observation {
  KeyFrameId key_frame;
  uint32_t feature = 0;  // index into the key frame's features
};

struct MapPoint {
  static constexpr uint32_t kMostFrames = 1u << 31;  // that are counted

  Eigen::Vector3d position_w = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_w = Eigen::Vector3d::Zero();  // mean unit vector from the observers' centres to the point
  Descriptor descriptor;                               // the observation's with the least median distance to the others
  float d_min = 0, d_max = 0;                          // distances at which the pyramid can see it
  std::vector<Observation> observations;               // sorted by key-frame handle
  KeyFrameId reference;  // the observer that gives d_min, d_max (erased: the next observer)
  uint32_t visible = 1;  // frames in which it was predicted in view
  uint32_t found = 1;    // frames in which it was matched

  bool seen_by(KeyFrameId key_frame) const {
    const auto at = std::ranges::lower_bound(observations, key_frame, {}, &Observation::key_frame);
    return at != observations.end() && at->key_frame == key_frame;
  }
  // The feature by which an observer sees it.
  uint32_t feature_in(KeyFrameId observer) const {
    return std::ranges::lower_bound(observations, observer, {}, &Observation::key_frame)->feature;
  }
};

// The members of MapPoint that follow from its observations, under the same names.
struct PointAppearance {
  Eigen::Vector3d normal_w;
  float d_min = 0, d_max = 0;
  Descriptor descriptor;
};

struct Neighbour {
  KeyFrameId key_frame;
  int weight = 0;  // points shared
};

struct KeyFrame {
  uint32_t serial = 0;  // counts key frames as they are made, never reused
  uint32_t submap = 0;  // id of the submap it belongs to
  int64_t frame = 0;    // index of the frame in the recording
  Timestamp stamp = 0;
  SE3 T_cw;
  FeaturesPtr features;
  std::shared_ptr<const Words> words;  // its visual words; null without a vocabulary
  std::vector<MapPointId> points;      // for each feature its map point, or an invalid handle
  std::vector<Neighbour> shared;       // every key frame sharing at least one point, sorted by handle; always exact
  KeyFrameId parent;                   // in the submap's spanning tree; invalid for its root
  std::vector<KeyFrameId> children;    // sorted by handle
  std::vector<KeyFrameId> loop_edges;  // sorted by handle
  ColoursPtr colours;                  // null: its image came without colours
  double scale = 1;  // product of the changes of scale that loop closing brought to this key frame: poses given
                     // relative to it before a change have translations in the old unit
};

// Ids count submaps as they are begun and are never reused.
struct Submap {
  uint32_t id = 0;
  KeyFrameId root;
  size_t key_frames = 0;
};

struct MapState;  // map_state.h

class Map {
 public:
  // ---- Key frames ----
  // Adds a key frame without points to an existing submap; without `submap`, to the oldest. The first of all begins a
  // submap as begin_submap() does. Refuses (invalid handle) a pose that is not finite.
  KeyFrameId add_key_frame(int64_t frame, Timestamp stamp, const SE3& T_cw, FeaturesPtr features,
                           std::optional<uint32_t> submap = {});
  // Adds a key frame as the root of a new submap.
  KeyFrameId begin_submap(int64_t frame, Timestamp stamp, const SE3& T_cw, FeaturesPtr features);
  // Makes the best covisible key frame (most shared points; ties: lower serial) its parent; the newest other key frame
  // of its submap when it shares nothing. Call once, after the observations of a new key frame are in.
  void attach_to_tree(KeyFrameId id);
  // Erases it with its observations and edges; points left with fewer than two observers go too (one is enough if that
  // observer has depth for it). Children are re-attached as in §2 of algorithms.md. False (and nothing done) for a
  // root or a stale one. Its pose relative to its parent stays known to resolve().
  bool erase_key_frame(KeyFrameId id);
  const KeyFrame* find(KeyFrameId id) const { return key_frames_.find(id); }         // nullptr: stale
  const KeyFrame& at(KeyFrameId id) const { return key_frames_.at(id); }             // must be live (asserted)
  KeyFrameId key_frame_in(uint32_t slot) const { return key_frames_.handle(slot); }  // invalid: none
  MapPointId point_in(uint32_t slot) const { return points_.handle(slot); }          // invalid: none
  // False (nothing done) when stale or not finite.
  bool set_pose(KeyFrameId id, const SE3& T_cw);
  // Makes it known to the database. Once.
  void set_words(KeyFrameId id, std::shared_ptr<const Words> words);
  // The same keypoints in other places (asserted: as many). False (nothing done) when stale.
  bool set_features(KeyFrameId id, FeaturesPtr features);
  // One for each feature (asserted). False (nothing done) when stale.
  bool set_colours(KeyFrameId id, ColoursPtr colours);
  // The correction of a loop: the pose, and the factor by which lengths near this key frame grew. Counted by moves(),
  // as is join_submaps(): what was read of the map before such a move does not fit what is read after it.
  bool correct_pose(KeyFrameId id, const SE3& T_cw, double growth);
  void add_loop_edge(KeyFrameId a, KeyFrameId b);
  const KeyFrameDatabase& database() const { return database_; }
  size_t key_frame_count() const { return key_frames_.size(); }
  std::vector<KeyFrameId> key_frames() const;                 // by rising serial
  std::vector<KeyFrameId> key_frames(uint32_t submap) const;  // those of one submap

  // A live key frame that stands for `id`, and T_ar that takes r = the returned one's camera to a = the asked one's
  // camera: itself and the identity when live; for an erased one the nearest living ancestor. Nothing for a handle that
  // never was. `scale`: KeyFrame::scale of the asked one (an erased one shares the changes of its living ancestor).
  struct Resolved {
    KeyFrameId key_frame;
    SE3 T_ar;
    double scale = 1;
    // The pose of a camera given relative to the asked key frame, relative to the returned one. T_ca, and
    // KeyFrame::scale of the asked one, as they were when the camera was there: a loop may have changed lengths around
    // it since.
    SE3 carry(const SE3& T_ca, double scale_then) const {
      return SE3(T_ca.R(), Eigen::Vector3d(scale / scale_then * T_ca.t())) * T_ar;
    }
  };
  std::optional<Resolved> resolve(KeyFrameId id) const;
  // Key frames erased so far. The first `count` of them are forgotten by forget_erased(): resolve() finds nothing for
  // them from then on. For handles that nobody holds any more; TrajectoryLog::reanchor() says when.
  uint64_t erasures() const { return erasures_; }
  void forget_erased(uint64_t count);
  size_t erased_count() const { return erased_frames_.size(); }  // erased key frames that resolve() knows

  uint64_t moves() const { return moves_; }
  // All of it was adjusted: counted by moves().
  void count_move() { ++moves_; }

  // ---- The camera ----
  // The camera that all undistorted keypoints are of. They stay as they are when its focal length is refined; with
  // another residual distortion they are made anew (set_features(), features/straightening.h).
  const Pinhole& camera() const { return camera_; }
  void set_camera(const Pinhole& camera) { camera_ = camera; }

  // ---- Submaps ----
  const std::vector<Submap>& submaps() const { return submaps_; }  // by rising id: the oldest first
  const Submap* submap(uint32_t id) const;                         // nullptr: there is none (any more)
  KeyFrameId root() const { return submaps_.empty() ? KeyFrameId{} : submaps_.front().root; }  // the oldest submap's
  bool is_root(KeyFrameId id) const;
  // Joins the submap of `child` to that of `parent`: all of it is moved by S (p_there = S * p_here), `child` becomes
  // the root of its tree, and `parent` the parent of `child`. False (nothing done) when either is stale, both are of
  // one submap, or S is not finite.
  bool join_submaps(KeyFrameId child, KeyFrameId parent, const Sim3& S);
  // Everything of a submap goes. False when there is none of this id.
  bool erase_submap(uint32_t id);

  // ---- Covisibility (derived from `shared`) ----
  int weight(KeyFrameId a, KeyFrameId b) const;            // points both observe
  std::vector<Neighbour> neighbours(KeyFrameId id) const;  // edges, heaviest first; ties: lower handle first
  std::vector<Neighbour> best_neighbours(KeyFrameId id, int count) const;  // the first `count` of them
  void best_neighbours(KeyFrameId id, int count,
                       std::vector<Neighbour>& list) const;                  // the same; list keeps its memory
  std::vector<Neighbour> neighbours_above(KeyFrameId id, int weight) const;  // those of at least this weight
  int tracked_points(KeyFrameId id, int min_observers) const;  // its points with at least so many observers
  // Edges of the essential graph: tree, loop edges and covisibility of at least kEssentialThreshold; each pair once,
  // a.serial > b.serial.
  std::vector<std::pair<KeyFrameId, KeyFrameId>> essential_graph() const;

  // ---- Points ----
  // Adds a point seen by `feature` of `reference` (its first observation). Refuses (invalid handle) a position that is
  // not finite, or a feature that has a point already.
  MapPointId add_point(const Eigen::Vector3d& position_w, KeyFrameId reference, uint32_t feature);
  // False when either is stale, the feature has a point, or the key frame already observes this point or is of another
  // submap.
  bool add_observation(MapPointId point, KeyFrameId key_frame, uint32_t feature);
  // Removes one observation; the point goes too when too few are left (as in erase_key_frame). False when there is
  // none.
  bool erase_observation(MapPointId point, KeyFrameId key_frame);
  bool erase_point(MapPointId id);
  // Moves the observations of `old` to `by` (where `by` is already seen by that key frame, the feature is let go), adds
  // up visible and found, refreshes `by`, erases `old` and forwards its handle. False when either is stale, both are
  // the same, or of different submaps.
  bool replace_point(MapPointId old, MapPointId by);
  // The live handle that `id` has become through replacements; invalid when it was erased.
  MapPointId forwarded(MapPointId id) const;
  // Forgets replacements made before the key frame of this serial, whose handles nobody should hold any more. A handle
  // they forwarded then counts as erased, never as another point: generations differ.
  void forget_forwarding(uint32_t before_serial);
  size_t forwarding_count() const { return replaced_by_.size(); }
  const MapPoint* find(MapPointId id) const { return points_.find(id); }
  const MapPoint& at(MapPointId id) const { return points_.at(id); }
  bool set_position(MapPointId id, const Eigen::Vector3d& position_w);  // false when stale or not finite
  // A live point's appearance as its observations have it now. It takes long where there are many: they are compared
  // pair by pair.
  PointAppearance appearance(MapPointId id) const;
  void set_appearance(MapPointId id, const PointAppearance& appearance);
  // Both at once.
  void refresh_point(MapPointId id) { set_appearance(id, appearance(id)); }
  // Only normal and distance range: after poses or positions moved.
  void refresh_point_geometry(MapPointId id);
  void count_visible(MapPointId id, uint32_t frames);
  void count_found(MapPointId id, uint32_t frames);
  size_t point_count() const { return points_.size(); }
  std::vector<MapPointId> points() const;  // by rising slot

  // Calls visit(MapPointId, const MapPoint&) / visit(KeyFrameId, const KeyFrame&) by rising slot.
  template <class Visit>
  void for_each_point(Visit&& visit) const {
    points_.for_each(visit);
  }
  template <class Visit>
  void for_each_key_frame(Visit&& visit) const {
    key_frames_.for_each(visit);
  }

  uint32_t next_serial() const { return next_serial_; }
  uint32_t next_submap() const {
    return next_submap_;
  }  // id that the next submap gets: those there are have lower ones
  uint64_t refused_non_finite() const { return refused_non_finite_; }  // commits refused for a non-finite pose or point

  // The first broken invariant found, described; empty when all hold: observations mutual, weights exact and mutual,
  // each submap's tree a tree that holds every key frame of it, no link to an erased thing or another submap,
  // everything finite, counts consistent.
  std::string check() const;

  // ---- Saving and loading (map_state.h) ----
  MapState state() const;
  // The map of a state, with fresh handles. An error says what is wrong with it: nothing of the state is trusted, and
  // check() holds for what is returned.
  static Result<Map> from_state(MapState state);

 private:
  struct Ancestor {
    KeyFrameId parent;
    SE3 T_cp;                            // pose relative to the parent at erasure
    double scale = 1, parent_scale = 1;  // scales of both at erasure
    uint64_t erasure = 0;                // counts erasures, from 1
  };

  struct Replacement {
    MapPointId by;
    uint32_t serial = 0;  // the serial of the key frame that was newest then
  };

  SlotStore<KeyFrameId, KeyFrame> key_frames_;
  SlotStore<MapPointId, MapPoint> points_;
  std::unordered_map<MapPointId, Replacement> replaced_by_;  // iterated for forgetting alone, where order is nothing
  std::unordered_map<KeyFrameId, Ancestor> erased_frames_;   // likewise
  KeyFrameDatabase database_;
  Pinhole camera_;
  std::vector<Submap> submaps_;  // by rising id; each has a key frame
  uint32_t next_submap_ = 0;
  uint32_t next_serial_ = 0;
  uint64_t refused_non_finite_ = 0, moves_ = 0, erasures_ = 0;

  Submap& submap_at(uint32_t id);
  KeyFrameId insert_key_frame(int64_t frame, Timestamp stamp, const SE3& T_cw, FeaturesPtr features, uint32_t submap);
  void reroot_tree(KeyFrameId id);
  void add_weight(KeyFrameId a, KeyFrameId b, int delta);
  void rebuild_shared();                                     // makes it anew for all key frames, from the observations
  void find_submaps(const std::vector<KeyFrameId>& frames);  // from the trees; frames by rising serial
  void unlink_observations(MapPointId id);
  void reattach_children(KeyFrameId id);
};

}  // namespace covis
