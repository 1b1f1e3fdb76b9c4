// SPDX-License-Identifier: Apache-2.0
// Corrects a loop only as far as its points determine the correction. A loop is often closed when only a corner of the
// place is in view. Points in a small part of the image do not determine all parameters of a similarity, and errors
// that the points share then bend the map by more than it had drifted. So the correction is the most probable one,
// given the points and a drift whose standard deviation grows with how far the scene moved past the camera. Directions
// that the points determine follow the points; the others are left nearly unchanged. A correction that is much greater
// than expected in directions that are determined shows that the drift was greater than expected: then its variance is
// enlarged in all directions.
//
// This is a maximum a posteriori estimate, with an empirical Bayes variance of the drift (Efron and Morris, JASA 1973).
// Measured: docs/notes/049-loops-against-drift.md.
#pragma once

#include "covis/geometry/alignment.h"
#include "covis/geometry/sim3.h"

namespace covis {

struct ExpectedDrift {
  double past = 0;   // how far the scene moved past the camera since the place (Travel::past()), in the map's unit
  double depth = 0;  // of the points that are in view, in the map's unit
  Scale scale = Scale::free;
};

// Returns the most probable correction. `correction`: what the points say, from the camera's frame of reference as the
// map has it to that which the loop finds, in the map's unit. `information`: the inverse covariance of xi in
// exp(xi) * correction by the noise of the pixels alone; it may be singular.
Sim3 weigh_against_drift(const Sim3& correction, const Matrix7d& information, const ExpectedDrift& drift);

}  // namespace covis
