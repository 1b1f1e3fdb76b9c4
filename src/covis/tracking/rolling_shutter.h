// SPDX-License-Identifier: Apache-2.0
// A rolling shutter, found from the frames as they are tracked. A camera that turns moves the keypoints of each row by
// another angle. Between two views that turn in other ways, no motion explains their matches. What a lens or a focal
// length errs does not follow the turns. Once it is found, the turn between rows is taken out of the keypoints of each
// frame (features/unrolling.h). Measured: docs/notes/053-rolling-shutter.md.
#pragma once

#include <optional>
#include <vector>

#include "covis/features/features_ring.h"
#include "covis/map/shared_map.h"
#include "covis/tracking/tracked_frame.h"
#include "covis/tracking/tracking_options.h"

namespace covis {

class RollingShutter {
 public:
  // readout: TrackerOptions::readout. rows: of an image.
  RollingShutter(double readout, int rows)
      : finds_(readout == kFindReadout), rows_(rows), readout_(finds_ ? 0 : readout) {}

  // The features of a frame in which the rays turn so fast (MotionModel::turn_rate()); the same where nothing is known.
  FeaturesPtr straighten(FeaturesPtr features, const Pinhole& camera, const std::optional<Eigen::Vector3d>& turn_rate);
  // The step from the frame before to that of the last straighten(), once it has its pose.
  struct Step {
    const TrackedFrame& frame;
    SE3 T_lw;  // the frame before
    Timestamp before = 0;
    KeyFrameId reference;
    bool becomes_key_frame = false;
  };
  // Compares the frame with the key frame `reference`, and remembers its turn where it becomes one itself. live: null
  // while the map may not be read. Nothing is compared where the map has moved since `moves`.
  void follow(const Step& step, const Pinhole& camera, const SharedMap* live, std::optional<uint64_t> moves);
  // Seconds from the exposure of the first row to that of the last; 0: there is none, or none was found yet. Negative:
  // the last row comes first, as in a camera that is mounted upside down.
  double readout() const { return readout_; }

 private:
  struct Turn {
    Timestamp stamp = 0;
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();   // radians a second
    Eigen::Vector3d taken = Eigen::Vector3d::Zero();  // the part taken out of its keypoints, radians an image
  };
  // The least squares of frames: curvature * readout = slope.
  struct Sums {
    double curvature = 0, slope = 0;
  };
  struct Blocks {
    int count = 0;
    Sums all;
    double curvature2 = 0, product = 0, slope2 = 0;  // sums over the blocks
  };
  const Turn* turn_of(Timestamp stamp) const;
  void compare(const TrackedFrame& frame, const Pinhole& camera, const Eigen::Vector3d& turn_rate, const Map& map,
               KeyFrameId reference);
  void end_block();

  bool finds_;
  int rows_;
  double readout_;
  FeaturesRing ring_{5};
  Eigen::Vector3d taken_ = Eigen::Vector3d::Zero();  // the tracked frame's
  std::vector<Turn> key_frames_;                     // those of this run, by rising stamp
  Sums block_;
  int frames_ = 0;  // in the block
  Blocks blocks_;
};

}  // namespace covis
