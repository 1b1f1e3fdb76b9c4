// SPDX-License-Identifier: Apache-2.0
// Finds a lost camera in the map, and the place of single images. Candidates come from the words of the image, from
// around the last reference key frame, and from all key frames in turn; each is matched by descriptor, a pose is found
// by PnP in RANSAC and then from the local map around it. Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015,
// section V-C.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "covis/tracking/pose_search.h"
#include "covis/tracking/track_result.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

class Relocaliser {
 public:
  // Without a vocabulary (null) a lost camera is looked for at the nearest key frames, and at few others in turn.
  Relocaliser(const SharedMap& map, const TrackerOptions& options, int seed,
              std::shared_ptr<const Vocabulary> vocabulary);

  struct Where {
    KeyFrameId near;              // the key frame that the camera was at last, if any
    std::optional<uint32_t> but;  // a submap that it is not looked for in
  };
  // Looks for the frame's pose. `live` is null while the map may not be read: the reference key frame in the local map
  // is all there is then. True: the frame has its pose and matches, and the local map is that around it.
  bool find(TrackedFrame& frame, PoseSearch& search, const SharedMap* live, const Where& where, TrackFigures& figures);

  // Returns the pose of one image in the map, from the image alone; no pose when its place is not recognised. `probe`
  // looks at that image; null: only its features are left.
  struct Located {
    SE3 T_cw;
    uint32_t submap = 0;
    int inliers = 0;       // map points that agree with the pose
    Matrix6d information;  // of T_cw, given the map
    RelativePose pose;     // relative to the nearest key frame
  };
  std::optional<Located> locate(FeaturesPtr features, int64_t frame, const ImageProbe* probe = nullptr);

 private:
  // `words`: those of the image; null without a vocabulary.
  std::vector<KeyFrameId> candidates(const Map& map, const Words* words, const Where& where);
  bool find_at(const KeyFrameView& view, TrackedFrame& frame, PoseSearch& search, const SharedMap* live,
               TrackFigures& figures) const;
  bool find_first_pose(const KeyFrameView& view, TrackedFrame& frame, PoseSearch& search) const;

  const SharedMap& map_;
  const TrackerOptions options_;
  const int seed_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  size_t turn_ = 0;  // index of the key frame that is tried next in turn
};

}  // namespace covis
