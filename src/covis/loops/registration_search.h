// SPDX-License-Identifier: Apache-2.0
// The registration of depth images to images, from points whose places are known without depth. Where a depth image is
// looked up in the right place, its depths are those of the points; anywhere else they are those of their neighbours.
// Measured figures: docs/notes/052-depth-that-is-not-registered.md.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "covis/features/kept_depth.h"
#include "covis/geometry/depth_registration.h"

namespace covis {

// A point in a view.
struct DepthSight {
  const KeptDepth* depth = nullptr;  // the view's
  Eigen::Vector2f image;             // pixel of the view's image, distorted: depth that is registered is there
  Eigen::Vector2f pixel;             // the same without distortion: any other registration begins there
  float z = 0;                       // metres
  int view = 0;                      // sights of different views do not share errors
};

// How well depths agree with points.
struct RegistrationFit {
  double error = 0;  // mean share by which a depth is off, each at most 0.1, their median taken as right
  int measured = 0;  // sights that have a depth
};
// centre: the image's principal point.
RegistrationFit fit_of(const std::vector<DepthSight>& sights, const DepthRegistration& registration,
                       const Eigen::Vector2d& centre);

// Another registration than `present` whose error is less than `share` of the present one's: whichever half of the
// views it is found with, the other half says so, and both halves find about the same. It has a parallax where its
// error is clearly less with one. Nothing: the present one may stay.
std::optional<DepthRegistration> find_registration(const std::vector<DepthSight>& sights,
                                                   const DepthRegistration& present, const Eigen::Vector2d& centre,
                                                   double share);

}  // namespace covis
