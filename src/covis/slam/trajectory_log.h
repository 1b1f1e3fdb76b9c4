// SPDX-License-Identifier: Apache-2.0
// The record of every frame: the pose it got when it was tracked, and the same pose relative to a key frame, which
// carries every later correction (algorithms.md §6). Older frames are in a temporary file. The tracking thread writes;
// any thread may read.
//
// Each call holds the log's own lock while it copies or changes plain values; poses are worked out by the reader, from
// its copy and the map. Who needs the map's guard too takes it first.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "covis/core/spilled_array.h"
#include "covis/core/time.h"
#include "covis/map/key_frame_moves.h"
#include "covis/map/map_requests.h"

namespace covis {

// A camera in the world of a submap: the camera of the submap's first key frame.
struct SubmapPose {
  SE3 T_wc;
  uint32_t submap = 0;  // Submap::id
};

struct FrameRecord {
  int64_t frame = 0;
  Timestamp stamp = 0;
  std::optional<RelativePose> pose;  // with every correction; nothing: the frame has no pose in the map
  ShutterResponse shutter = {};      // the correction of `pose` that is left to the reader
  uint64_t moves = 0;                // Map::moves() of the map that it was tracked in
  // The pose as it was when the frame was tracked; nothing: there was none. (The first view of a monocular submap gets
  // its pose later.)
  std::optional<SubmapPose> online;
};

class TrajectoryLog {
 public:
  // `most`: so many of the newest frames are kept at least, and at most twice as many; 0: all.
  explicit TrajectoryLog(size_t most = 0) : most_(most) {}

  // Frames rise.
  void append(const FrameRecord& record);
  // Appending allocates nothing as long as this is called now and then.
  void make_room();
  // A frame that became a key frame is its own reference from now on: `pose` is relative to itself. A frame that had no
  // pose until then gets `online` as the one it was tracked with.
  void anchor(int64_t frame, const RelativePose& pose, const std::optional<SubmapPose>& online = {});
  // A frame without a pose was located afterwards; one that has a pose keeps it.
  void locate(const LocatedFrame& located);
  // Takes back the poses of this frame and all later ones: the place proved wrong. Returns the stamp of the first that
  // had one.
  std::optional<Timestamp> retract(int64_t from);
  // Takes back the poses of all frames that are in this submap. Call before the submap is erased.
  void forget(const Map& map, uint32_t submap);

  // Key frames moved with another camera. Frames that were tracked before stay between those that they were between:
  // where the last one before, the next one after and the reference would each carry a frame, the nearer ones count
  // more.
  void follow(const Map& map, const KeyFrameMoves& moves);

  // Every so many erased key frames, gives each pose relative to a key frame that lives, and returns how many erasures
  // the map may forget (Map::forget_erased()): those before the last time, to which no request or frame on its way
  // refers any more.
  std::optional<uint64_t> reanchor(const Map& map);

  std::optional<FrameRecord> last() const;
  std::vector<FrameRecord> records() const;
  // Rises with every change.
  uint64_t revision() const;

 private:
  FrameRecord* find(int64_t frame);

  const size_t most_;
  mutable std::mutex mutex_;  // guards what follows
  SpilledArray<FrameRecord> records_;
  uint64_t revision_ = 0;
  uint64_t reanchored_at_ = 0;  // Map::erasures() of the last reanchor()
};

}  // namespace covis
