// SPDX-License-Identifier: Apache-2.0
// The pose of a tracked frame from matches whose places are refined (matching/patch_alignment.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "covis/map/shared_map.h"
#include "covis/matching/patch_alignment.h"
#include "covis/matching/point_set.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// Keeps its work space between frames.
class MatchAlignment {
 public:
  MatchAlignment();

  // Refines frame.T_cw, which its matches were fitted with, and its information. The matches stay, also those that do
  // not fit as closely as aligned ones should. The pose stays too where these are more than half, or where the map has
  // moved since `moves`. `live`: null while the map may not be read; then the views serve that were kept.
  void refine_pose(const SharedMap* live, const Pinhole& camera, std::optional<uint64_t> moves, TrackedFrame& frame);
  // Keeps the reference views of these points, as they are now.
  void keep_views(const Map& map, const PointSet& points);

 private:
  // A key frame that is the reference of points.
  struct Reference {
    KeyFrameId id;
    FeaturesPtr features;
    SE3 T_cw;
    SE3 T_vr;  // to the frame that is aligned
  };
  struct View {
    MapPointId point;
    uint32_t reference = 0;  // in references_
    uint32_t feature = 0;    // the reference's
    Eigen::Vector3d p_r;     // the point in the reference camera, metres
  };
  struct Question {
    uint32_t feature = 0;
    PatchQuestion of_point;
  };
  void ask(const Map& map, const Pinhole& camera, const TrackedFrame& frame);
  void ask_kept(const Pinhole& camera, const TrackedFrame& frame);
  // Asks where a feature of the frame is that shows the point p_r of this reference, which saw it by `seen`.
  void add(const Pinhole& camera, const TrackedFrame& frame, size_t feature, const Features& reference, size_t seen,
           const Eigen::Vector3d& p_r, const SE3& T_vr);
  const View* kept_view(MapPointId point) const;
  void observe(const Pinhole& camera, const TrackedFrame& frame);

  std::vector<Reference> references_;
  std::vector<View> views_;          // kept, in the order of their points
  std::vector<Question> questions_;  // by rising feature
  PoseObservations observations_;
  std::vector<uint8_t> inlier_;
};

}  // namespace covis
