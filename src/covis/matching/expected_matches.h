// SPDX-License-Identifier: Apache-2.0
// The points of a map that a view should match, by how often they usually do, against those that it does. Things of
// which there are several alike match wherever one of them stands; their surroundings do not. Points that were seen
// from about here before say most (docs/notes/005-expected-match-ratio.md).
#pragma once

#include <algorithm>

#include "covis/map/map.h"

namespace covis {

// How much a point's view from one centre differs from that of another.
struct ViewChange {
  double cosine = 0;  // cosine of the angle between the rays
  double factor = 1;  // greater distance by the smaller one

  ViewChange(const Eigen::Vector3d& point_w, const Eigen::Vector3d& centre_w, const Eigen::Vector3d& other_w) {
    const Eigen::Vector3d ray = point_w - centre_w, other = point_w - other_w;
    const double distance = ray.norm(), other_distance = other.norm();
    cosine = ray.dot(other) / (distance * other_distance);
    factor = std::max(distance, other_distance) / std::min(distance, other_distance);
  }
  bool is_near() const { return cosine > 0.866 && factor < 2.1; }    // from the same side, within 30 degrees
  bool is_here() const { return cosine > 0.9962 && factor < 1.44; }  // from about there, within 5 degrees
};

// The number of points expected to match, and the number that do.
struct MatchTally {
  double expected = 0;
  int found = 0;

  // Enough are expected for the share that is found to say something.
  bool enough() const { return expected >= 60; }
  bool reaches(double share) const { return found >= share * expected; }
};

struct ExpectedMatches {
  MatchTally from_here;  // points that were seen from within 5 degrees, and known well
  MatchTally from_near;  // from within 30 degrees, and known well
  MatchTally young_too;  // the same with those not known well yet

  // A point that is in view of a camera with its centre there.
  void add(const MapPoint& point, const Map& map, const Eigen::Vector3d& centre_w, bool matched);
};

}  // namespace covis
