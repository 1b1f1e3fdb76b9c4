// SPDX-License-Identifier: Apache-2.0
// Tests whether an image is torn: some of its rows, displaced by a fault of a cable, a buffer or a driver, show known
// points far from where the pose that the other rows tell has them. Points made of such rows would bend the map.
// Measured: docs/notes/043-torn-images.md.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "covis/core/time.h"
#include "covis/matching/nearest_row.h"
#include "covis/tracking/local_map.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// The points that a frame should show and shows elsewhere in the same rows, all moved alike, and the rows where it
// shows them.
struct DisplacedRows {
  int sampled = 0;    // such points among those that were looked for
  int displaced = 0;  // such points in all, as the sample says
  int sightings = 0;  // points among those that were looked for that are seen elsewhere, by whatever way
  int inliers = 0;    // matches in these rows that agree with the pose

  bool shows_tear() const;
  bool may_show_tear() const;  // after a frame that did, of which fewer points may be in view
};

// Keeps its work space between frames: it allocates nothing in a steady state.
class TornImage {
 public:
  TornImage();
  // True when a frame with fewer matches than usual is torn, or may be, as one was just before. Not for longer than
  // three seconds, or until a whole frame came: it may be a large thing that was moved. `expected`: a flag for each
  // point of the local map that the frame should show.
  bool judge(const LocalMap& local_map, std::span<const uint8_t> expected, const TrackedFrame& frame,
             const Pinhole& camera);
  // A frame had as many matches as usual.
  void whole() {
    torn_at_.reset();
    torn_since_.reset();
  }
  // A frame shows far less than usual of what it should. True when that is so because it is torn, as one was just
  // before: so long after torn frames too few known points are in view to see them displaced.
  bool judge_after_torn(Timestamp now) {
    if (!may_go_on(now)) return false;
    torn_at_ = now;
    return true;
  }
  // True when the frame of this stamp counted as torn.
  bool was_torn(Timestamp stamp) const { return is_believed(stamp) && torn_lately(stamp, kGap); }
  // True for a second after a torn frame, or until a whole one: no map is to begin with what may be torn too.
  bool may_go_on(Timestamp now) const { return is_believed(now) && torn_lately(now, 1.0); }

  DisplacedRows look(const LocalMap& local_map, std::span<const uint8_t> expected, const TrackedFrame& frame,
                     const Pinhole& camera);

 private:
  // A point seen far from where it is expected.
  struct Sighting {
    Eigen::Vector2f way;  // pixels
    float row = 0;
  };
  struct Match {
    uint32_t point = 0, position = 0;  // in the local map; in others_
  };
  void find_sightings(const LocalMap& local_map, const TrackedFrame& frame, const Pinhole& camera);

  static constexpr double kGap = 0.2;       // seconds; a torn frame may show too little of the map to tell
  static constexpr double kBelieved = 3.0;  // seconds
  bool is_believed(Timestamp now) const { return !torn_since_ || now - *torn_since_ < from_seconds(kBelieved); }
  bool torn_lately(Timestamp now, double seconds) const { return torn_at_ && now - *torn_at_ < from_seconds(seconds); }
  std::optional<Timestamp> torn_at_, torn_since_;
  MatchedPoints matched_;
  std::vector<uint32_t> missing_;          // points of the local map
  std::vector<uint8_t> free_;              // by feature: 1 without a point
  DescriptorPlanes others_;                // descriptors of those features
  AlignedVector<uint64_t> nearest_point_;  // for each of them
  std::vector<Match> matches_;
  std::vector<Sighting> sightings_;
  std::vector<float> rows_, most_rows_;
};

}  // namespace covis
