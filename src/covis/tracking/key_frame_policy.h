// SPDX-License-Identifier: Apache-2.0
// Decides when a frame becomes a key frame, and makes the request to mapping. Source: Mur-Artal, Montiel, Tardós,
// "ORB-SLAM", T-RO 2015, section V-E; close points: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, III-D.
#pragma once

#include <vector>

#include "covis/core/schedule.h"
#include "covis/map/map_requests.h"
#include "covis/tracking/local_map.h"
#include "covis/tracking/point_counts.h"
#include "covis/tracking/tracked_frame.h"
#include "covis/tracking/tracking_options.h"

namespace covis {

enum class MappingLoad { idle, busy };  // idle: mapping would begin with a key frame at once

class KeyFramePolicy {
 public:
  KeyFramePolicy(Sensor sensor, const KeyFrameOptions& options, Schedule schedule)
      : sensor_(sensor), options_(options), schedule_(schedule) {}

  // Counts the points of its local map that an accepted frame had in view and matched.
  void count(const TrackedFrame& frame, const LocalMap& local_map, const std::vector<uint8_t>& in_view) {
    counts_.add(local_map.points.id, in_view, frame);
  }
  // True when the frame, with so many map points, should become a key frame.
  bool is_due(const TrackedFrame& frame, int inliers, const LocalMap& local_map, const Pinhole& camera,
              MappingLoad load) const;
  // Makes the request for a key frame of it; `pose` is its pose relative to its reference key frame.
  KeyFrameRequest request(const TrackedFrame& frame, const RelativePose& pose, const Pinhole& camera);
  // A submap begins with this frame.
  void begin(Timestamp stamp) { last_stamp_ = stamp; }
  void clear_counts() { counts_.clear(); }

  // Depth in metres up to which a point is close.
  double close_depth(const Pinhole& camera) const { return options_.close_depth.metres(camera); }
  // The features whose depth makes points: select_near_features().
  const std::vector<uint32_t>& near_features(const Features& features, const Pinhole& camera);

 private:
  bool few_close_points(const TrackedFrame& frame, const Pinhole& camera) const;
  bool moved_away(const TrackedFrame& frame, const KeyFrameView& reference) const;
  bool turned_away(const TrackedFrame& frame, const KeyFrameView& reference, const Pinhole& camera) const;

  const Sensor sensor_;
  const KeyFrameOptions options_;
  const Schedule schedule_;
  PointCounts counts_;
  Timestamp last_stamp_ = 0;  // stamp of the last key frame asked for
  std::vector<uint32_t> near_;
};

}  // namespace covis
