// SPDX-License-Identifier: Apache-2.0
// The p of the map near the camera, copied in one short read into flat arrays: the tracker works on this copy and
// takes no lock while it does. Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section V-D.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/map/map.h"

namespace covis {

// A copy of one key frame: enough to track against without the map.
struct KeyFrameView {
  KeyFrameId id;
  uint32_t submap = 0;  // of the map
  SE3 T_cw;
  double scale = 1;  // KeyFrame::scale
  FeaturesPtr features;
  std::vector<MapPointId> points;          // for each feature, invalid: none
  std::vector<Eigen::Vector3d> positions;  // for each feature, world, meaningful where points is valid

  void copy(const Map& map, KeyFrameId key_frame);
};

class LocalMap {
 public:
  LocalMap();
  // Makes the local map anew round the key frames that share points with `matched` (K1), their best covisible key
  // frames, children and parents (K2), at most `max_key_frames`. Without any, round `fallback`. The key frame that
  // shares most becomes the reference.
  void update(const Map& map, const std::vector<MapPointId>& matched, KeyFrameId fallback, int max_key_frames);
  void clear();

  // One entry a point, in a fixed order.
  std::vector<MapPointId> id;
  AlignedVector<double> px, py, pz;   // world position, metres
  AlignedVector<float> nx, ny, nz;    // mean viewing direction, from the observers to the point
  AlignedVector<float> d_min, d_max;  // distances at which it can be seen, metres
  AlignedVector<Descriptor> descriptor;

  std::vector<KeyFrameId> key_frames;  // K1 first
  KeyFrameView reference;
  int reference_all_points = 0;  // points of the reference key frame that another one observes too
  int reference_points = 0;      // points of the reference key frame with enough observers (3, or 2 in a young map)

  int size() const { return static_cast<int>(id.size()); }

 private:
  void select_key_frames(const Map& map, const std::vector<MapPointId>& matched, KeyFrameId fallback,
                         int max_key_frames);
  void copy_points(const Map& map);

  uint32_t epoch_ = 0;
  std::vector<uint32_t> point_seen_, key_frame_seen_;  // by slot: the epoch in which it was added
  std::vector<int> votes_;                             // by key-frame slot: matched points it observes
  std::vector<KeyFrameId> voted_;
  std::vector<Neighbour> neighbours_;
};

}  // namespace covis
