// SPDX-License-Identifier: Apache-2.0
// The first pose of a frame, before the local map is searched: where the last frame's points, or those of the
// reference key frame, show it to be. Several hypotheses compete, and the one with the most points that agree wins: a
// search around a wrong prediction finds matches too, by chance, but few that agree.
//
//   motion       the last frame's points around where constant velocity expects them
//   images       the same with the rotation that the images show (image_rotation.h)
//   descriptors  the last frame's points by descriptor alone, a pose by P3P in RANSAC
//   reference    the reference key frame's points by descriptor alone
//
// The later ones are tried only when the earlier ones explain little of what the last frame showed. Where the frame's
// depth contradicts the points (depth_against_map.h) it loses its depth: the image alone shows the pose.
// Sources: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section V-B; geometry/pnp.h.
#pragma once

#include <optional>

#include "covis/tracking/depth_against_map.h"
#include "covis/tracking/image_rotation.h"
#include "covis/tracking/pose_search.h"
#include "covis/tracking/track_result.h"

namespace covis {

class FirstPose {
 public:
  // all_points: points from the last frame's own depth count too. map_points: they help the pose but do not carry it.
  enum class Support { map_points, all_points };
  FirstPose(Sensor sensor, const FirstPoseOptions& options, Support support, int seed)
      : sensor_(sensor), options_(options), support_(support), seed_(seed) {}

  void set_support(Support support) { support_ = support; }
  // Finds the pose of `frame` and its matches. `T_cl` is the predicted motion since the last frame, if there is one.
  // frame.features are without depth afterwards where it contradicts the map. False: figures.reason says why.
  bool find(const TrackedFrame& last, const std::optional<SE3>& T_cl, TrackedFrame& frame, PoseSearch& search,
            TrackResult& figures);
  // True when the images were asked for their rotation, as the prediction explained little, and show this one.
  bool images_agree(const SE3& T_cl) const;

 private:
  struct Hypothesis {
    TrackMethod method = TrackMethod::none;
    int matches = 0;
    int inliers = 0;                           // matches that agree with the pose
    double share = 0;                          // share of the last frame's points in view that agree
    DepthAgainstMap depth{};                   // before the pose was fitted
    NoPoseReason reason = NoPoseReason::none;  // none when there is a pose
    bool ok() const { return reason == NoPoseReason::none; }
    // So many of the last frame's points in view agree that no other pose needs to be looked for.
    bool explains() const { return ok() && share >= 0.2; }
  };
  Hypothesis by_motion(const TrackedFrame& last, const SE3& T_cl, TrackedFrame& frame, PoseSearch& search);
  Hypothesis by_images(const TrackedFrame& last, const SE3& T_cl, TrackedFrame& frame, PoseSearch& search);
  Hypothesis by_descriptors(const TrackedFrame& last, TrackedFrame& frame, PoseSearch& search);
  Hypothesis by_reference(const TrackedFrame& last, TrackedFrame& frame, PoseSearch& search) const;
  // The last frame's points around where frame.T_cw expects them. `camera`: without depth, that of the frame counts
  // not.
  Hypothesis around(const TrackedFrame& last, TrackedFrame& frame, PoseSearch& search, const Pinhole& camera);
  bool depth_is_suspicious(const TrackedFrame& last, const Hypothesis& found, const Pinhole& camera);
  // The pose by the image alone, and the frame without its depth, if that contradicts the map; else `found`.
  Hypothesis by_image_alone(const TrackedFrame& last, const SE3& T_cl, const Hypothesis& found, TrackedFrame& frame,
                            PoseSearch& search);

  const Sensor sensor_;
  const FirstPoseOptions options_;
  Support support_;
  const int seed_;
  std::optional<Eigen::Matrix3d> turn_seen_;  // the rotation that the images show; empty: not asked, or not seen
  TrackedFrame best_;                         // the frame as the best hypothesis so far has it
  DepthComparer depth_;
  DepthRemover remover_;
};

}  // namespace covis
