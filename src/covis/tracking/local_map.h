// SPDX-License-Identifier: Apache-2.0
// The points of the map near the camera, copied in one short read into flat arrays: the tracker works on this copy and
// takes no lock while it does. Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section V-D.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/map/key_frame_view.h"
#include "covis/matching/point_set.h"

namespace covis {

class LocalMap {
 public:
  LocalMap();
  // Makes the local map anew around the key frames that share points with `matched` (K1), their best covisible key
  // frames, children and parents (K2), at most `max_key_frames`. Without any, it is made around `fallback`. The key
  // frame that shares most becomes the reference.
  void update(const Map& map, const std::vector<MapPointId>& matched, KeyFrameId fallback, int max_key_frames);
  void clear();

  PointSet points;                     // the order depends on the map and the matches alone
  std::vector<float> match_ratio;      // share of frames expected to match the point when it is in view
  std::vector<KeyFrameId> key_frames;  // K1 first
  KeyFrameView reference;
  int reference_all_points = 0;  // points of the reference key frame that another one observes too
  int reference_points = 0;      // points of the reference key frame with enough observers (3, or 2 in a young map)

  int size() const { return static_cast<int>(points.size()); }
  // True of its points that one key frame alone observes: nothing has shown yet that they do not move.
  bool is_new(MapPointId point) const { return point.slot < new_.size() && new_[point.slot] == epoch_; }

 private:
  void select_key_frames(const Map& map, const std::vector<MapPointId>& matched, KeyFrameId fallback,
                         int max_key_frames);
  void copy_points(const Map& map);

  uint32_t epoch_ = 0;
  std::vector<uint32_t> point_seen_, key_frame_seen_;  // by slot: the epoch in which the point or key frame was added
  std::vector<uint32_t> new_;                          // by point slot: the epoch in which the point was new
  std::vector<int> votes_;                             // by key-frame slot: matched points it observes
  std::vector<KeyFrameId> voted_;
  std::vector<Neighbour> neighbours_;
};

}  // namespace covis
