// SPDX-License-Identifier: Apache-2.0
// Two views that turn in different ways, compared for the readout of a rolling shutter: no motion between them explains
// what that does to their matches. Matches that the frame's pose refused are asked as well, as a readout that is not
// known yet moves keypoints far from the middle by more than a pose allows. Wrong ones count little, as all others
// speak against them. Source of the weights: Geman and McClure, "Statistical methods for tomographic image
// reconstruction", 1987.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "covis/geometry/se3.h"
#include "covis/tracking/readout_estimate.h"

namespace covis {

class ReadoutComparison {
 public:
  // A point that both views show: how its pixel moves in the second one, and where it is from where it should be.
  struct Match {
    Eigen::Matrix<double, 2, 6> by_motion;   // with the motion between the views, a twist on the left
    Eigen::Matrix<double, 2, 3> by_shutter;  // with the readout, pixels a second; with the row of the principal point;
                                             // and the residual with the turns in it, pixels
    double information = 1;                  // 1 / pixels^2
  };
  struct Result {
    ReadoutEquations equations;  // the motion is eliminated
    Vector6d motion;             // that a second of readout looks like
  };

  // Begins anew, with room for so many matches.
  void start(size_t most);
  void add(const Match& match) { matches_.push_back(match); }
  // present: the readout in use, seconds. Nothing where the matches are too few to tell a motion.
  std::optional<Result> result(double present);

 private:
  void weigh(const Eigen::Matrix<double, 6, 3>& explained, double readout);

  std::vector<Match> matches_;
  std::vector<double> weights_;
};

}  // namespace covis
