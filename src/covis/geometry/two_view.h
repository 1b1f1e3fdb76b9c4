// SPDX-License-Identifier: Apache-2.0
// Structure and motion from two views without a prior, from a homography or a fundamental matrix, whichever fits the
// matches better.
// Sources: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section IV; Hartley and Zisserman, "Multiple View
// Geometry", 2004, sections 4.1, 4.4 (normalised DLT), 9.6, 11.2 (8 points); Faugeras and Lustman, "Motion and
// structure from motion in a piecewise planar environment", 1988.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis {

struct TwoViewMatches {
  std::vector<Eigen::Vector2d> a, b;  // undistorted pixels in the first and the second view
  std::vector<double> sigma2;         // variance of each match, pixels^2; empty: 1 for all
};

struct TwoViewOptions {
  int iterations = 200;            // number of RANSAC samples of 8 matches
  double homography_ratio = 0.45;  // S_H / (S_H + S_F) above which the homography is used
  double min_parallax_deg = 1.0;
  int min_points = 50;          // least number of triangulated points of an accepted motion
  double min_good_share = 0.9;  // least TwoViewMotion::share of an accepted motion
  // A motion that explains more than this share (below 1) of the matches of the best one is a rival of it.
  double clear_winner = 0.75;
  // Times min_parallax_deg: asked of a motion of a plane that only matches off the plane tell from its rivals, as a
  // plane tells the motion less precisely. Infinite: such matches decide nothing.
  double plane_parallax = 2;
  uint64_t seed = 0;
};

enum class TwoViewStatus { ok, too_few_matches, no_model, no_clear_winner, too_few_points, low_parallax };

struct TwoViewMotion {
  SE3 T_21;                               // maps camera 1 to camera 2 coordinates, |t| = 1
  std::vector<Eigen::Vector3d> points_1;  // one per match, in the first camera's coordinates
  std::vector<uint8_t> triangulated;      // one per match: 1 when points_1 is valid
  int explained = 0;                      // matches that it explains, triangulated or too far away
  int behind = 0;                         // matches of points so far away that noise puts them behind the cameras
  double share = 0;                       // share of the model's inliers that are either
  double parallax_deg = 0;  // n-th largest parallax of a point, degrees; n: a quarter of the points, at least 50

  // ok, or the reason why it is none to begin a map with.
  TwoViewStatus status(const TwoViewOptions& options) const;
};

struct TwoViewResult {
  TwoViewStatus status = TwoViewStatus::too_few_matches;
  // ok: the motion. no_clear_winner: where the views show a plane, the rivals between which they do not decide, best
  // first. Otherwise none.
  std::vector<TwoViewMotion> motions;
  bool homography = false;  // true: motion from the homography; false: from the fundamental matrix
  double score_h = 0, score_f = 0;
};

TwoViewResult reconstruct_two_views(const TwoViewMatches& matches, const Pinhole& camera,
                                    const TwoViewOptions& options);

}  // namespace covis
