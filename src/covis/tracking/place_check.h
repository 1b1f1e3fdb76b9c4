// SPDX-License-Identifier: Apache-2.0
// Judges whether a pose is of the place it claims to be. Things of which there are several alike match wherever one of
// them stands; their surroundings do not. So a place that the camera cannot have walked to has to show the points
// usually seen from there, and stays tentative for a second: until then no key frame is made of it, and when it proves
// wrong the frames since then lose their poses. Measured: docs/notes/005-expected-match-ratio.md.
//
//      relocalised, jumped, or doubted          here for a second
//   settled ───────────────────────▶ tentative ──────────────────▶ settled
//                                        │ lost, or jumped again
//                                        └──▶ the poses since the jump are taken back
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "covis/features/image_probe.h"
#include "covis/map/shared_map.h"
#include "covis/matching/shown_points.h"
#include "covis/tracking/local_map.h"
#include "covis/tracking/tracked_frame.h"
#include "covis/tracking/tracking_options.h"
#include "covis/tracking/usual_interval.h"

namespace covis {

// The frames that follow in a stream confirm a place or refute it; a single image stands for itself and has to show
// more.
enum class Subject { stream, single_image };
// The way in which the camera came to the place: from around the prediction or the reference key frame, by descriptors
// of the last frame wherever they led, or relocalised after a loss. The last two lead as readily to a place that only
// looks the same.
enum class Arrival { tracked, recognised, relocalised };

class PlaceCheck {
 public:
  PlaceCheck(const RecoveryOptions& options, Subject subject) : options_(options), subject_(subject) {}

  struct Found {
    const TrackedFrame& frame;  // the frame at the place, with its matches
    const LocalMap& local_map;
    std::span<const uint8_t> in_view;   // a flag for each point of the local map
    const SharedMap* live;              // null: the map may not be read now, and its copies serve
    const ImageProbe* image = nullptr;  // null: the frame's image is gone
  };
  // True when the frame may be where it was found.
  bool is_right(const Found& found, Arrival arrival);
  // True when the image shows the points of the map evenly where the frame's pose has them, corners or not: then no
  // other place looks like this one, however few points match.
  bool is_shown(const Found& found) const;
  // The place of this frame, which is right as far as one can tell, is tentative for a second from now.
  void doubt(const TrackedFrame& frame);
  // The same frame is tracked: its pose holds.
  void accept(const TrackedFrame& frame, uint32_t submap);
  // The camera is lost: a tentative place was wrong.
  void lose();
  // The camera is at this place without doubt: a submap was just begun there. Where it was before may have been
  // tentative.
  void restart_at(const TrackedFrame& frame, uint32_t submap) {
    jump_.reset();
    last_ = {frame.T_cw, submap, frame.stamp};
  }
  // The camera may be anywhere.
  void restart();
  // The map moved, and the last place with it; lengths there grew by the factor `growth`.
  void follow(const SE3& T_cw, uint32_t submap, double growth);
  // A loop was closed, or submaps were joined: where the camera was before the last frame is not known any more.
  void forget_settled() { settled_.clear(); }

  bool tentative() const { return jump_.has_value(); }
  // The stamp of the frame with which the camera came to its tentative place.
  std::optional<Timestamp> tentative_since() const { return jump_ ? std::optional(jump_->stamp) : std::nullopt; }
  // The frame from which on poses are to be taken back, reported once.
  std::optional<int64_t> take_retraction();

 private:
  struct Place {
    SE3 T_cw;
    uint32_t submap = 0;
    Timestamp stamp = 0;
    Timestamp interval = 0;  // since the frame before, in a burst since an earlier one; 0: unknown
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // that of the centre in the camera, metres a second
  };
  struct Jump {
    int64_t frame = 0;
    Timestamp stamp = 0;
  };
  // The place to hold one in this submap against; null if there is none.
  const Place* came_from(uint32_t submap, Timestamp now) const;
  bool jumped(const Found& found, Arrival arrival) const;
  static bool is_long_ago(const Place& place, Timestamp now);
  // The camera is at this place without doubt.
  void settle(const Place& place);
  enum class Demand { usual, strict };  // strict: after a jump, and while the place is tentative
  // The image can do this beside matches: make a place right where they are few, or wrong where they are enough.
  enum class Witness { for_it, against_it, both };
  bool looks_as_expected(const Found& found, Demand demand, Witness image);
  struct Matches {
    bool enough = false;     // as many as usual, about
    double least_shown = 1;  // ShownPoints::even_share() of the image without which they do not make a place right
  };
  Matches matches_as_expected(const Found& found, const Map& map, Demand demand);
  // There are none without an image to show them.
  std::optional<ShownPoints> points_to_show(const Found& found, const Map& map) const;
  void take_back_jump();

  const RecoveryOptions options_;
  const Subject subject_;
  std::vector<MapPointId> matched_;  // map points of the frame being judged, sorted
  std::optional<Place> last_;        // place of the last frame with a pose, unless that was taken back
  std::vector<Place> settled_;       // for each submap the last place there that was not tentative
  UsualInterval usual_;
  std::optional<Jump> jump_;  // the frame with which the camera jumped to a place that is tentative still
  std::optional<int64_t> retract_from_;
};

// True when the position's standard deviation moves things at the mean depth by two pixels at most. A few points on one
// side of the image agree with poses far apart, and wrong matches choose among those.
bool well_determined(const Matrix6d& information, double mean_depth, const Pinhole& camera);

}  // namespace covis
