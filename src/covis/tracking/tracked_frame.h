// SPDX-License-Identifier: Apache-2.0
// A frame while it is tracked: its features, its pose, and which known point each feature shows.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "covis/core/time.h"
#include "covis/map/map_requests.h"

namespace covis {

// The source of the position of a feature's point.
enum class PointSource : uint8_t {
  none,
  map,    // a map point
  depth,  // a measured depth: the last frame's, or one from before where that has none
};

struct TrackedFrame {
  // A feature that was matched with a map point, which the frame's pose then refused.
  struct Refused {
    uint32_t feature = 0;
    MapPointId point;
  };

  static constexpr Timestamp kNever = std::numeric_limits<Timestamp>::min();

  int64_t index = -1;  // index in the recording
  Timestamp stamp = 0;
  FeaturesPtr features;
  SE3 T_cw;
  Matrix6d information = Matrix6d::Zero();  // of T_cw, by the last fit (PoseResult::information)
  std::vector<MapPointId> points;           // by feature: its map point, or an invalid handle
  std::vector<Eigen::Vector3d> positions;   // by feature: in the world, metres; meaningful where it has a source
  std::vector<PointSource> source;          // by feature
  std::vector<Refused> refused;             // since clear_matches(), no more than there are features
  std::vector<uint8_t> was_refused;         // by feature: the pose refused its last match, whose position is kept
  std::vector<Timestamp> moved;             // by feature: when it was last seen to move by itself, or kNever

  // A request to make a key frame of it: the image alone, no point and no pose.
  KeyFrameRequest request() const;

  void start(FeaturesPtr f, int64_t frame, Timestamp t);
  // Becomes a copy without the features, which their ring wants back.
  void keep(const TrackedFrame& other);
  // Its keypoints are made free of this camera's residual distortion, where they are not.
  void straighten_for(const Pinhole& camera);
  void reserve(size_t n);  // room for n features
  void clear_matches();
  void set_match(size_t feature, MapPointId point, const Eigen::Vector3d& position_w, PointSource from);
  void drop_match(size_t feature);
  // The same where the pose was fitted to it and others.
  void refuse_match(size_t feature);
  // Matches a feature with the point of an earlier frame's feature, and copies when that moved.
  void take_match(size_t feature, const TrackedFrame& earlier, size_t feature_there);
  // True for half a second after the feature was seen to move by itself: who turns round stands for a moment.
  bool moves(size_t feature) const {
    constexpr Timestamp kRemembered = from_seconds(0.5);
    return moved[feature] != kNever && stamp - moved[feature] <= kRemembered;
  }
  bool on_map(size_t feature) const { return source[feature] == PointSource::map; }
  // Fills `matched` with its map points, by feature.
  void map_points(std::vector<MapPointId>& matched) const;
  // Features with a point, from wherever it comes.
  int matches() const;
  // Mean depth of its map points; 0 without any.
  double mean_depth() const;
};

// The map points that a frame shows, for many questions about one frame.
class MatchedPoints {
 public:
  MatchedPoints();
  void mark(const TrackedFrame& frame);
  bool contains(MapPointId id) const { return id.slot < mark_.size() && mark_[id.slot] == epoch_; }

 private:
  std::vector<uint32_t> mark_;  // by point slot: the epoch in which it was marked
  uint32_t epoch_ = 0;
};

}  // namespace covis
