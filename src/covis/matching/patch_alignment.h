// SPDX-License-Identifier: Apache-2.0
// The place of a match, refined: the patch of a point's reference view is laid over that of another view, as the motion
// between them distorts it, and moved to where the grey levels fit best. Corners are found to half a pixel of their
// level, patches fit to an eighth (docs/notes/051-aligned-matches.md).
// Source: Baker and Matthews, "Lucas-Kanade 20 years on: a unifying framework", IJCV 2004, section 3.2 (inverse
// compositional), with gain and offset of the grey levels; the distortion of a plane that faces the reference camera:
// Klein and Murray, "Parallel tracking and mapping for small AR workspaces", ISMAR 2007, section 5.3.
// Patches are of the image as it is, with its distortion; the warp is that of pinhole cameras, as neighbours are
// distorted alike in both views.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "covis/features/features.h"
#include "covis/geometry/measurement.h"
#include "covis/geometry/se3.h"

namespace covis {

// The weight of an aligned match, in that of a keypoint.
inline float aligned_weight(const Pinhole& camera) {
  constexpr double kSigma = 0.3;  // in those of a keypoint
  // With a depth sensor the errors of neighbouring pixels are alike, by a rolling shutter or the registration of the
  // images; those of its depths are weighted for that too.
  const double sigma = camera.depth_noise.known() ? kAlikeErrors * kSigma : kSigma;
  return static_cast<float>(1 / (sigma * sigma));
}

// A keypoint in its patch.
struct PatchView {
  Patch patch;
  Eigen::Vector2f at = Eigen::Vector2f::Zero();       // pixels of the patch
  Eigen::Vector2f stretch = Eigen::Vector2f::Ones();  // image pixels for one of the patch

  // There is none where the feature has no patch.
  static std::optional<PatchView> of(const Features& features, size_t feature);
};

// The step in the reference's patch for each of two steps of a pixel in the view's patch, columns; nothing where the
// patches differ too much to be compared.
// p_r: the point in the reference camera, metres. T_vr: from the reference to the view.
std::optional<Eigen::Matrix2f> patch_warp(const Pinhole& camera, const Eigen::Vector3d& p_r, const SE3& T_vr,
                                          const Eigen::Vector2f& stretch_r, const Eigen::Vector2f& stretch_v);

// By how much the keypoint moves in the view's patch, pixels of it. Nothing where it would move by more than one, or
// the patches are not alike.
std::optional<Eigen::Vector2f> align_patch(const PatchView& reference, const Eigen::Matrix2f& warp,
                                           const PatchView& view);

// The place of a feature that moves by `step` pixels of its patch.
struct AlignedPlace {
  Eigen::Vector2f image = Eigen::Vector2f::Zero();        // distorted pixels
  Eigen::Vector2f undistorted = Eigen::Vector2f::Zero();  // pixels of the map's camera
};
std::optional<AlignedPlace> moved_place(const Features& features, size_t feature, const Eigen::Vector2f& step,
                                        const Eigen::Vector2f& stretch);

// The place of a point in a view, by the patch of its reference.
struct PatchQuestion {
  PatchView reference;
  Eigen::Matrix2f warp = Eigen::Matrix2f::Identity();

  // Nothing where there are no patches, or they differ too much. p_r: the point in the reference camera, metres.
  static std::optional<PatchQuestion> of(const Pinhole& camera, const Features& reference, size_t seen,
                                         const Eigen::Vector3d& p_r, const SE3& T_vr, const Features& view,
                                         size_t feature);
  std::optional<AlignedPlace> answer(const Features& view, size_t feature) const;
};

}  // namespace covis
