// SPDX-License-Identifier: Apache-2.0
// The search by projection: where a camera at a given pose should see known points, and which keypoints there look like
// them. Tracking (last frame, local map), fusion and loop closing all search so; what they ask of a match is a gate
// with a name. Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, sections V-B, V-D, VI-C and VII-B.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "covis/geometry/se3.h"
#include "covis/matching/point_set.h"
#include "covis/matching/window_match.h"

namespace covis {

// The pyramid levels at which a point is looked for.
enum class LevelRule {
  predicted,       // from its range of distances: that level and the one finer
  around_seen,     // the level at which it was just seen, one finer and one coarser
  seen_or_larger,  // that level and all coarser ones: the camera moves ahead
  seen_or_finer,   // that level and all finer ones: the camera moves back
};

// Says if a matched keypoint must lie within the 95 % bound of its measurement error.
enum class MatchError { not_asked, within_bound };

// The conditions of a match. Windows are half their side, pixels x scale of the level.
struct MatchGate {
  double window = 4;
  double window_frontal = 4;  // for points seen nearly as before (cosine above 0.998)
  int max_distance = kHammingHigh;
  float ratio = 1;                          // best against second-best distance at one level; 1: not asked
  LevelRule levels = LevelRule::predicted;  // other rules: sets of points just seen
  MatchError error = MatchError::not_asked;

  // The points of the last frame, where the motion model expects them.
  static MatchGate last_frame(double window, LevelRule levels) {
    return {.window = window, .window_frontal = window, .levels = levels};
  }
  // The points of the local map.
  static MatchGate local_map(double window, double window_frontal, double ratio) {
    return {.window = window, .window_frontal = window_frontal, .ratio = static_cast<float>(ratio)};
  }
  // The points of a place that may close a loop.
  static MatchGate loop(double window) {
    return {.window = window, .window_frontal = window, .max_distance = kHammingLow};
  }
  // Points that may be the same as those a key frame has.
  static MatchGate fusion(double window, MatchError error) {
    return {.window = window, .window_frontal = window, .max_distance = kHammingLow, .error = error};
  }
};

// A point where a camera should see it.
struct PredictedView {
  float u = 0, v = 0;   // pixels, undistorted
  float disparity = 0;  // pixels; 0: the camera has no depth sensor
  float cosine = 1;     // between the viewing ray and the point's mean viewing direction
  int level = 0;        // predicted pyramid level
};

// No view when the point is behind the camera, outside the image, outside 0.8 d_min … 1.2 d_max, or seen at more than
// 60 degrees from its mean viewing direction (ORB-SLAM, V-D). `centre_w` is that of T_cw.
std::optional<PredictedView> predict_view(const ViewablePoint& point, const SE3& T_cw, const Eigen::Vector3d& centre_w,
                                          const Pinhole& camera, const Features& features);

struct PointMatch {
  uint32_t feature = 0;
  uint32_t point = 0;  // index into the set
};

// Keeps its work space between calls: a search allocates nothing once its vectors have grown.
class ProjectionMatcher {
 public:
  ProjectionMatcher();

  struct Frame {
    const Pinhole& camera;
    const Features& features;
    SE3 T_cw;
  };
  // Finds the points of a set in a frame; matches() holds them by rising point. Points with known[k] != 0 (empty span:
  // none) are in view, and not searched; features with taken[i] != 0 (likewise) are passed over. Returns how many
  // points are in view.
  int match(const PointSet& points, const Frame& frame, const MatchGate& gate, std::span<const uint8_t> known = {},
            std::span<const uint8_t> taken = {});

  const std::vector<PointMatch>& matches() const { return matches_; }
  // The points in view that look like no feature near them, by rising point.
  const std::vector<uint32_t>& unlike() const { return unlike_; }
  // For each point of the last search whether it was in view.
  const std::vector<uint8_t>& in_view() const { return in_view_; }
  // Drops the matches whose keypoints turned otherwise than the bulk: angle[k] is the orientation of point k when it
  // was seen last, radians. Returns how many are left.
  int keep_consistent_rotations(std::span<const float> angle, const Features& features);

 private:
  std::optional<WindowQuery> query(const PointSet& points, size_t k, const Frame& frame,
                                   const Eigen::Vector3d& centre_w, const MatchGate& gate) const;
  std::optional<WindowQuery> query_seen(const PointSet& points, size_t k, const Frame& frame,
                                        const MatchGate& gate) const;

  WindowMatcher windows_;
  std::vector<WindowQuery> queries_;
  std::vector<uint32_t> source_;  // for each query its point
  std::vector<int32_t> found_;    // for each query its feature, or below 0
  std::vector<PointMatch> matches_;
  std::vector<uint32_t> unlike_;
  std::vector<uint8_t> in_view_;
  std::vector<float> angle_then_, angle_now_;
  std::vector<uint8_t> keep_;
};

}  // namespace covis
