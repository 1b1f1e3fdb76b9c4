// SPDX-License-Identifier: Apache-2.0
// Whether a camera can have been at a pose: by where it was just before and after, and how fast it moved in the run.
// The place of a single image may be a look-alike, which a camera does not reach in a moment.
#pragma once

#include <map>
#include <vector>

#include "covis/slam/snapshot.h"

namespace covis {

class PathReach {
 public:
  // Poses by rising stamp.
  explicit PathReach(std::vector<PoseOfFrame> path);
  // True where the pose lies within reach of the nearest poses of its submap before and after it. One of them has to be
  // near in time.
  bool admits(const PoseOfFrame& pose) const;
  // So near: a third of a second, or the next frame where they come more slowly.
  double longest() const { return longest_; }
  void add(const PoseOfFrame& pose);

 private:
  struct Speed {
    double forward = 0, turning = 0;  // units of the map and radians a second
  };
  bool reaches(const PoseOfFrame& from, const PoseOfFrame& to) const;

  std::vector<PoseOfFrame> path_;
  double longest_ = 0;              // seconds
  std::map<uint32_t, Speed> most_;  // of each submap: as fast as the camera moved in all but a twentieth of its steps
};

}  // namespace covis
