// SPDX-License-Identifier: Apache-2.0
// The map and the trajectory as those outside see them: one value, which never changes and needs no lock. Poses are
// resolved, and nothing of it refers to the map. Units and frames are those of map.h.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "covis/map/shared_map.h"
#include "covis/slam/trajectory_log.h"
#include "covis/snapshot.h"

namespace covis {

struct PoseOfFrame : SubmapPose {
  int64_t frame = 0;
  Timestamp stamp = 0;
};

// A map of its own within the whole (Map::submaps()). There is more than one when the camera was lost and what was
// mapped before and after has not been joined (yet).
struct SubmapSummary {
  uint32_t id = 0;
  bool loaded = false;  // it came with a map put in place, or was joined to one that did
  size_t frames = 0;    // frames of the recording that have a pose in it
  size_t key_frames = 0, points = 0;
};

struct Snapshot {
  struct KeyFrame : PoseOfFrame {
    KeyFrameId id;
    KeyFrameId parent;    // in its submap's spanning tree; invalid: the root
    uint32_t serial = 0;  // KeyFrame::serial
    uint32_t camera = 0;  // the one that made it: 0: that in use; else its index in other_cameras, plus one
  };
  struct Point {
    MapPointId id;
    Eigen::Vector3d position_w;
    uint32_t submap = 0;
    Colour colour = kNoColour;
  };

  uint64_t revision = 0;                     // rises when map or trajectory change
  Pinhole camera;                            // intrinsics of the frames, as refined until now
  std::vector<RefinedCamera> other_cameras;  // that made some of the key frames; see Features::made_by
  std::vector<SubmapSummary> submaps;        // loaded ones first, then those with more frames, then the older ones
  std::vector<KeyFrame> key_frames;          // as they were made
  std::vector<Point> points;                 // by rising slot
  std::vector<MapSnapshot::Edge> edges;
  std::vector<MapSnapshot::Observation> observations;  // key frame by key frame
  std::vector<PoseOfFrame> trajectory;  // frames that have a pose, with every correction, by rising frame
  // Frames that had a pose when they were tracked, as it was then; submap: the one it was in, which may have been
  // joined to another since.
  std::vector<PoseOfFrame> online;
  uint64_t refused_non_finite = 0;  // Map::refused_non_finite()

  // Index into submaps; nothing when there is no such submap (any more).
  std::optional<size_t> index_of(uint32_t submap) const;
};

// Poses of one submap; empty without one.
std::vector<PoseOfFrame> poses_in(const std::vector<PoseOfFrame>& poses, std::optional<uint32_t> submap);

// Makes snapshots of a map and its trajectory, anew only when either changed. All calls are safe from any thread.
class SnapshotSource {
 public:
  SnapshotSource(const SharedMap& map, const TrajectoryLog& log) : map_(map), log_(log) {}

  // A map was put in place, submaps of ids below `loaded_end`.
  void map_loaded(uint32_t loaded_end);
  // The newest one. A thread that asks while one is made waits for it. Making one first copies the log's
  // records, then holds a read guard of the map: do not call it under a guard.
  std::shared_ptr<const Snapshot> get() const;
  // Members of it by themselves, without making one.
  Pinhole camera() const;
  std::vector<PoseOfFrame> trajectory() const;

 private:
  const SharedMap& map_;
  const TrajectoryLog& log_;
  mutable std::mutex mutex_;  // guards what follows
  mutable std::shared_ptr<const Snapshot> latest_;
  uint32_t loaded_end_ = 0;
};

}  // namespace covis
