// SPDX-License-Identifier: Apache-2.0
// The similarity between two cameras that see the same place, each with points of its own map: found among wrong
// matches (ransac_sim3), then refined on the pixels of both images (refine_sim3). Used to close loops and to recognise
// places. Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VII-B and appendix (the cost, both
// images); Horn, "Closed-form solution of absolute orientation using unit quaternions", JOSA A 1987; Fischler and
// Bolles, CACM 1981. S_12 maps camera 2's coordinates to camera 1's: p_1 = S_12 * p_2. The cost, summed over matches:
//   rho(|z_1 - h_1(S_12 p_2)|^2 inv_sigma2_1) + rho(|z_2 - h_2(S_12^-1 p_1)|^2 inv_sigma2_2).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "covis/geometry/alignment.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/sim3.h"

namespace covis {

struct Sim3Match {
  Eigen::Vector3d p_1, p_2;  // the point in camera 1's and in camera 2's coordinates, from each one's own map
  Eigen::Vector2d z_1, z_2;  // measurement in each image, undistorted pixels
  double inv_sigma2_1 = 1, inv_sigma2_2 = 1;  // 1 / pixels^2
};

struct Sim3Result {
  Sim3 S_12;
  int inliers = 0;
  // One per match: 1 when in front of both cameras and both squared errors are within the bound.
  std::vector<uint8_t> inlier;
  double cost = 0;  // cost over the inliers, without rho
  bool ok = false;  // false: fewer than 3 inliers, or a singular system; S_12 is the initial value then
};

inline constexpr double kRefineChi2 = 10.0;   // also Huber's bound
inline constexpr double kRansacChi2 = 9.210;  // 99 % for 2 degrees of freedom

// Levenberg-Marquardt: 5 iterations with Huber's rho, removal of the matches beyond max_chi2 in an image, then 10 more
// iterations without rho (5 if none were removed). Most matches must be right, like ransac_sim3's inliers or those of a
// search guided by its similarity; rho cannot cope with half of them wrong. With fix_scale the scale is kept.
Sim3Result refine_sim3(const Sim3& S_12, std::span<const Sim3Match> matches, const Pinhole& camera_1,
                       const Pinhole& camera_2, bool fix_scale, double max_chi2 = kRefineChi2);

// A point of one of two maps, measured in a view of the other. A similarity S takes the frame of reference of map a to
// that of map b.
struct CarriedPoint {
  enum class Way { forth, back };  // a point of a in a view of b, at T S p; or a point of b in a view of a, at T S^-1 p
  Way way = Way::forth;
  Eigen::Vector3d p;      // in the frame of reference of its own map
  SE3 T;                  // from the frame of reference of the other map to the view's camera
  Eigen::Vector2d z;      // measurement, undistorted pixels
  double inv_sigma2 = 1;  // 1 / pixels^2
};

struct CarriedResult {
  Sim3 S;
  int agreeing = 0;  // points within the bound
  bool ok = false;   // false: fewer than 3 agree, or a singular system; S is the initial value then
  // The inverse covariance of xi in exp(xi) S by the noise of the pixels, if ok; with a fixed scale its last row and
  // column are those of the identity.
  Matrix7d information = Matrix7d::Zero();
};

// Like refine_sim3(), with points of many views. One view may leave a direction open, of a plane for example; views
// from other places do not. The cost of a point: rho(|z - h(x)|^2 inv_sigma2), x its place in the view's camera.
CarriedResult refine_sim3(const Sim3& S, std::span<const CarriedPoint> points, const Pinhole& camera, Scale scale);

// Fits models to samples of 3 matches, at most 300, until an all-inlier sample was drawn with a probability of 99 %.
// The model with the most inliers is fitted again to those. Returns nullopt when it has fewer than min_inliers.
std::optional<Sim3Result> ransac_sim3(std::span<const Sim3Match> matches, const Pinhole& camera_1,
                                      const Pinhole& camera_2, bool fix_scale, uint64_t seed, int min_inliers = 20);

// Evaluates z - h for both images, and d h / d xi for S_12 <- exp(xi) S_12. Returns false when the point is behind a
// camera or not finite.
bool sim3_residual(const Sim3& S_12, const Sim3Match& match, const Pinhole& camera_1, const Pinhole& camera_2,
                   Eigen::Vector4d& e, Eigen::Matrix<double, 4, 7>* J = nullptr);

}  // namespace covis
