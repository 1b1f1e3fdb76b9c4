// SPDX-License-Identifier: Apache-2.0
// Measured depth against what images alone tell of it. The motion between two views follows from their keypoints
// (geometry/two_view.h), and the points are triangulated; the ratio of measured to triangulated depth is the same for
// all points where depth is right. No map is needed, which nonsense depth would have spoilt. A wrong scale of all
// depths does not show: the images know no scale. Depths whose own sigma is more than 5 % are left out: noise is no
// contradiction.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "covis/features/features.h"
#include "covis/geometry/camera.h"

namespace covis {

struct DepthAgainstMotion {
  int points = 0;     // depths compared
  double spread = 0;  // median of |log(ratio / median ratio)|: 0.1 means that half of the depths are off by 10 %
  double of_scene =
      0;  // the same of the triangulated depths by themselves: the spread that a constant depth would have
  double explained = 0;  // share of the points for which one motion explains the images by their measured depths

  // The error of depth where a constant depth, which tells nothing, has 1. Right depth has 0.05 to 0.5, depth that has
  // nothing to do with the images 1 to 3.
  double error() const { return of_scene > 0 ? spread / of_scene : 0; }
};

// nullopt where the views tell nothing: few matches, little parallax, or an ambiguous motion.
std::optional<DepthAgainstMotion> compare_depth_with_motion(const Features& a, const Features& b, const Pinhole& camera,
                                                            uint64_t seed);

// Compares views as they come, each with the last that was compared, until the camera has moved enough, and then also
// with the one before that.
class MotionDepthCheck {
 public:
  enum class Pace {
    usual,      // once enough views were compared, only one pair of a few: it takes milliseconds
    every_view  // once depth was doubted, so that the doubt can end, or come again
  };
  // `view` is kept.
  std::vector<DepthAgainstMotion> add(std::shared_ptr<const Features> view, const Pinhole& camera,
                                      Pace pace = Pace::usual);

 private:
  bool passes_over() const;
  void step(std::shared_ptr<const Features> view);

  std::shared_ptr<const Features> last_, before_last_;
  int waited_ = 0;  // views compared with the last in vain
  int attempts_ = 0, answers_ = 0;
  int passed_over_ = 0;  // views since the last attempt that were not looked at
};

}  // namespace covis
