// SPDX-License-Identifier: Apache-2.0
// Monocular initialisation: two views with enough parallax, by homography or fundamental matrix; of a plane, with the
// views in between (views_between.h).
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section IV.
#pragma once

#include <optional>
#include <vector>

#include "covis/geometry/camera.h"
#include "covis/map/map_requests.h"
#include "covis/matching/window_match.h"
#include "covis/tracking/tracking_options.h"
#include "covis/tracking/views_between.h"
#include "covis/types.h"

namespace covis {

class MonoInitializer {
 public:
  MonoInitializer(const StartOptions& options, int seed) : options_(options), seed_(seed) {}

  // Offers a frame of a camera of these intrinsics. Returns an initial map when it and the reference view make one;
  // reason() says why they do not.
  std::optional<InitialMapRequest> offer(const Pinhole& camera, const FeaturesPtr& features, int64_t frame,
                                         Timestamp stamp);
  // Forgets the reference view.
  void reset();
  NoPoseReason reason() const { return reason_; }
  int matches() const { return matches_; }

 private:
  void take_reference(const FeaturesPtr& features, int64_t frame, Timestamp stamp);
  int match_reference(const Features& features);
  // Keeps where the frame shows the reference view's features.
  void remember(const TwoViewMatches& pairs, const std::vector<uint32_t>& first_feature, Timestamp stamp);

  const StartOptions options_;
  const int seed_;
  InitialMapRequest::View reference_;
  std::vector<float> last_x_, last_y_;  // pixels: the last place of each reference feature, which its window follows
  ViewsBetween views_;
  std::vector<WindowQuery> queries_;
  std::vector<int32_t> query_feature_;
  std::vector<int32_t> match_;
  WindowMatcher matcher_;
  NoPoseReason reason_ = NoPoseReason::waiting_for_first_view;
  int matches_ = 0;
};

}  // namespace covis
