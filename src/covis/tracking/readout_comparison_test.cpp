// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/readout_comparison.h"

#include <gtest/gtest.h>

#include "covis/core/random.h"

namespace covis {
namespace {

// Matches with noise of half a pixel of a motion and a readout; of the wrong ones nothing is true.
ReadoutComparison comparison_of(double readout, int right, int wrong) {
  Random random(3);
  ReadoutComparison comparison;
  Vector6d motion;
  for (int i = 0; i < 6; ++i) motion(i) = 0.01 * random.normal();
  for (int k = 0; k < right + wrong; ++k) {
    ReadoutComparison::Match match{.by_motion = {}, .by_shutter = {}};
    for (int row = 0; row < 2; ++row) {
      for (int i = 0; i < 6; ++i) match.by_motion(row, i) = 300 * random.normal();
      match.by_shutter(row, 0) = 200 * random.normal();
      match.by_shutter(row, 1) = random.normal();
    }
    const Eigen::Vector2d noise(random.normal(), random.normal());
    match.by_shutter.col(2) =
        k < right ? Eigen::Vector2d(match.by_motion * motion + readout * match.by_shutter.col(0) + 0.5 * noise)
                  : Eigen::Vector2d(15 * noise);
    match.information = 4;
    comparison.add(match);
  }
  return comparison;
}

double readout_of(const ReadoutEquations& equations) { return equations.H.ldlt().solve(equations.b).x(); }

TEST(ReadoutComparison, TellsTheReadoutWhateverTheMotion) {
  for (const double readout : {-0.03, 0.0, 0.02}) {
    ReadoutComparison comparison = comparison_of(readout, 200, 0);
    EXPECT_NEAR(readout_of(comparison.result(0).value().equations), readout, 0.001);
  }
}

TEST(ReadoutComparison, WrongMatchesCountLittle) {
  ReadoutComparison comparison = comparison_of(0.02, 200, 60);
  EXPECT_NEAR(readout_of(comparison.result(0).value().equations), 0.02, 0.001);
}

TEST(ReadoutComparison, FewMatchesTellNothing) {
  ReadoutComparison comparison = comparison_of(0.02, 29, 0);
  EXPECT_FALSE(comparison.result(0));
  comparison.start(29);
  EXPECT_FALSE(comparison.result(0));
}

}  // namespace
}  // namespace covis
