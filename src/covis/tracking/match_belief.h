// SPDX-License-Identifier: Apache-2.0
// Judges whether a pose explains what the camera sees, by the share of the points in view that agree with it: of the
// local map's points nearly as many as usual must, or else of the last frame's points. A pose around a wrong
// prediction has matches by chance, 3 to 13 % of what is expected. How many are usual depends on the images (0.2 in one
// recording, 0.7 in another), so the shares of the frames before are what a frame is held against.
// Measured: docs/notes/022-a-pose-explains-its-view.md.
#pragma once

#include <algorithm>

#include "covis/tracking/track_result.h"

namespace covis {

class MatchBelief {
 public:
  // `images_agree`: the images show the same rotation as the pose, which makes a small share believable.
  bool explains_view(const TrackFigures& figures, bool images_agree) const {
    constexpr double kOfUsual = 0.35, kOfUsualConfirmed = 0.12;
    const double share = local_share(figures);
    return share >= kOfUsual * usual_local_ || figures.first_share >= kOfUsual * usual_first_ ||
           (images_agree && share >= kOfUsualConfirmed * usual_local_);
  }
  // True when clearly fewer points agree than usual.
  bool is_short(const TrackFigures& figures) const {
    constexpr double kOfUsual = 0.85;
    return local_share(figures) < kOfUsual * usual_local_;
  }
  // True when so few agree that a camera found again may be at a place that only looks alike, unless its image shows
  // that it does not (docs/notes/044-depth-doubted-sooner.md, 057-other-guises.md).
  bool is_weak(const TrackFigures& figures) const {
    constexpr double kOfUsual = 0.5;
    return local_share(figures) < kOfUsual * usual_local_;
  }
  // The frame's pose is believed.
  void accept(const TrackFigures& figures) {
    learn(usual_local_, local_share(figures));
    if (figures.first_share > 0) learn(usual_first_, figures.first_share);
  }

 private:
  static double local_share(const TrackFigures& figures) {
    return figures.inliers / std::max(1.0, figures.local_expected);
  }
  // A running mean over some 20 frames; it never falls to the share that chance gives.
  static void learn(double& usual, double share) {
    constexpr double kGain = 0.05, kLeast = 0.2;
    usual = std::max(kLeast, usual + kGain * (std::min(share, 1.0) - usual));
  }

  double usual_local_ = 0.5;
  double usual_first_ = 0.5;
};

}  // namespace covis
