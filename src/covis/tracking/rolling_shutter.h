// SPDX-License-Identifier: Apache-2.0
// A rolling shutter exposes the rows of an image one after the other. A camera that turns moves the keypoints of each
// row by another angle, which is taken out of them (features/unrolling.h) where the camera's row time is known. It is
// found from the frames as they are tracked: between two views that turn in other ways no motion explains their
// matches. Measured: docs/notes/053-rolling-shutter.md.
#pragma once

#include <memory>
#include <optional>

#include "covis/features/features_ring.h"
#include "covis/map/map.h"
#include "covis/map/map_requests.h"
#include "covis/tracking/readout_comparison.h"
#include "covis/tracking/readout_estimate.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

struct ShutterOptions {
  enum class RowTime { given, sought };

  int rows = 0;  // those of an image
  RowTime row_time = RowTime::given;
};

class RollingShutter {
 public:
  explicit RollingShutter(const ShutterOptions& options) : options_(options) {}
  RollingShutter(const RollingShutter&) = delete;  // a copy would not keep its room
  RollingShutter& operator=(const RollingShutter&) = delete;

  // The features of a frame without the turn between their rows, as far as the frames before tell it.
  FeaturesPtr straighten(FeaturesPtr features, const Pinhole& camera, Timestamp stamp);
  // The frame before.
  struct Last {
    SE3 T_cw;
    Timestamp stamp = 0;
  };
  // The frame has a pose, which tells its turn: what is left of that is taken out of the features that straighten()
  // made, if the frame still has them.
  void follow(const Last& last, const Pinhole& camera, const TrackedFrame& frame);
  // The turn of the last frame that was followed, of the rays, radians a second; zero: not known.
  const Eigen::Vector3d& turn_rate() const { return rate_; }

  // Compares a frame that was followed with a key frame that sees the same points. Returns what another row time does
  // to the pose between the two, where that is known.
  ShutterResponse compare(const TrackedFrame& frame, const Pinhole& camera, const Map& map, KeyFrameId reference);
  // The row time that frames tell, where one is sought and it is clearly another one than the camera's.
  std::optional<ShutterChange> found(const Pinhole& camera) const;

 private:
  const ShutterOptions options_;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();
  Timestamp stamp_ = 0;  // of the rate
  FeaturesRing ring_{5};
  std::shared_ptr<Features> straight_;  // those of the last straighten()
  ReadoutComparison comparison_;        // of the last compare()
  ReadoutEstimate estimate_;
  double estimated_with_ = 0;  // the camera's row time meanwhile
};

}  // namespace covis
