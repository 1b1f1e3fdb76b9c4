// SPDX-License-Identifier: Apache-2.0
// The depth that a frame measures against that of the map points which its images show. Depth that turns into nonsense
// in the midst of a recording contradicts the map made before: such a frame is tracked by its image alone, so that
// nothing is mapped from its depth. Measured: docs/notes/040-depth-that-contradicts-the-map.md,
// 054-depth-that-comes-back.md.
#pragma once

#include <optional>
#include <vector>

#include "covis/core/time.h"
#include "covis/features/features_ring.h"
#include "covis/map/shared_map.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// How depth differs from the part of the map that is compared.
struct DepthShape {
  int of_depth = 0;   // points that a measured depth gave; the scale of others drifts
  double error = 0;   // median of |log(measured / mapped)| once the map is scaled by the median ratio
  double relief = 0;  // median of |log(mapped / median mapped)|
};

struct DepthAgainstMap {
  int points = 0;     // depths compared
  double error = 0;   // median of |log(measured / depth of the map point)|: right depth has 0.001 to 0.03
  double sigmas = 0;  // the same in standard deviations of the depth, of a depth camera in five; 0 where the error
                      // agrees by itself
  std::optional<DepthShape> shape = {};  // known where the map could be read and the error does not agree by itself

  bool contradicts() const;
  bool agrees() const;  // neither where there are too few depths, or it may be either
  // True where images alone made what is seen of the map, and depth has the same shape but another scale: theirs
  // drifts. seconds: since depth and map contradicted each other first.
  bool differs_by_drift(double seconds) const;
  // True where it may contradict, after a search that itself matches only where depth agrees.
  bool is_suspicious() const;
};

class DepthComparer {
 public:
  DepthComparer();
  // Compares the points of the map that the frame shows at its pose, near enough for depth to be precise, with the
  // depth that `measured` has of them: the features that the frame came with.
  // With `map`, finds the shape too.
  DepthAgainstMap compare(const TrackedFrame& frame, const Features& measured, const Pinhole& camera,
                          const Map* map = nullptr);
  // The number of depths that would be compared.
  static int count(const TrackedFrame& frame, const Features& measured, const Pinhole& camera);

 private:
  struct Depth {
    double measured = 0, mapped = 0;  // metres
    size_t feature = 0;
  };
  DepthShape shape_in(const Map& map, const TrackedFrame& frame);
  std::vector<Depth> depths_;  // work space
  std::vector<double> values_;
};

// Makes of features those of the image alone.
class DepthRemover {
 public:
  FeaturesPtr without_depth(const Features& features);

 private:
  FeaturesRing ring_{5};  // images alone make key frames more often
};

// If depth and map contradict one another, either may be wrong. The map is believed at first; when the contradiction
// has lasted for as long as the two agreed before, or for two seconds, another map is to be begun. So it is, and at
// once, when the camera has left what was mapped with depth and they differ by drift: motion says that depth is right
// again.
class DepthBelief {
 public:
  // Takes the features of a frame; returns those to track it by: without depth as long as that contradicts.
  FeaturesPtr receive(FeaturesPtr measured);
  // The features as they came.
  const FeaturesPtr& measured() const { return measured_; }
  // A submap begins with the depth of this moment. Where that contradicted the map just before, nobody knows yet which
  // was wrong; not so where the camera was lost for long meanwhile.
  void begin(Timestamp stamp);
  // The frame is found in another map: what depth and the map before said of one another is past.
  void change_map(const TrackedFrame& frame);
  // The frame has its pose. Returns FrameDoubts::depth_contradiction. A contradiction lasts until the depth of some
  // frames in a row agrees.
  double judge(const TrackedFrame& frame, const Pinhole& camera, const SharedMap* live);
  void judge(const DepthAgainstMap& found, Timestamp stamp);
  bool contradicts() const { return since_.has_value(); }
  // True when the map is no longer to be believed more than the depth.
  bool blames_map(Timestamp now) const;
  // True for two seconds in which depth is to agree with a map that was begun upon a contradiction.
  bool is_on_probation(Timestamp now) const;
  // The moment in which the present map was begun, while it is on probation.
  std::optional<Timestamp> probation_since(Timestamp now) const { return is_on_probation(now) ? begun_ : std::nullopt; }
  // Motion says that depth is right up to its scale. So is a map that was made of it, unless it contradicts that depth.
  void trust_depth() {
    if (!contradicts()) doubted_.reset();
  }
  // The frame's keypoints are made free of this camera's residual distortion and of the turn between its rows. The
  // features that came with depth change with them, unless depth is doubted.
  void straighten_for(const Pinhole& camera, TrackedFrame& frame);
  // The frame is done: nothing is kept of it.
  void release() { measured_.reset(); }

 private:
  FeaturesPtr measured_;
  DepthComparer comparer_;
  DepthRemover remover_;
  std::optional<Timestamp> begun_, since_;  // without begun_ the map is older than the recording
  Timestamp judged_ = 0;
  DepthAgainstMap last_;              // while frames are tracked by their image alone
  int agreeing_ = 0, drifted_ = 0;    // frames in a row
  std::optional<Timestamp> doubted_;  // the moment in which a map was begun, not known yet to be right
};

}  // namespace covis
