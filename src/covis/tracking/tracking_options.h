// SPDX-License-Identifier: Apache-2.0
// Settings of tracking, a slice for each of its parts, each setting with its default, unit and meaning. Figures without
// another source are the published ones (Mur-Artal, Montiel, Tardós, T-RO 2015; Mur-Artal and Tardós, T-RO 2017;
// algorithms.md §3).
#pragma once

#include "covis/core/fields.h"
#include "covis/core/sensor.h"
#include "covis/geometry/camera.h"

namespace covis {

// The first pose of a frame, by one of several hypotheses (first_pose.h).
struct FirstPoseOptions {
  double motion_window = 15;        // pixels x scale: search around the predicted place (monocular, RGB-D)
  double motion_window_stereo = 7;  // the same for stereo
  int motion_min_matches = 20;      // with fewer, the search is repeated in windows twice as wide
  int motion_min_inliers = 10;      // inliers to accept the pose of the motion model or the reference key frame
  int reference_min_matches = 15;   // descriptor matches with the last frame or a key frame
  double reference_ratio = 0.7;     // best against second-best descriptor distance there

  double window(Sensor sensor) const { return sensor == Sensor::stereo ? motion_window_stereo : motion_window; }
};

// The search of the local map, and the acceptance of its pose.
struct LocalMapOptions {
  int local_key_frames = 80;          // key frames whose points make the local map, at most
  double local_window = 4;            // pixels x scale: search around a projected map point
  double local_window_frontal = 2.5;  // the same for a point seen nearly as before (cosine above 0.998)
  double local_window_rgbd = 3;       // factor on both windows for RGB-D
  double local_ratio = 0.8;           // best against second-best distance when both are of one level
  int min_inliers = 30;               // matched map points to accept a pose
  int weak_inliers = 80;  // with fewer inliers the next frames get twice the features, until 2.5 times as many

  double window_factor(Sensor sensor) const { return sensor == Sensor::rgbd ? local_window_rgbd : 1.0; }
};

// Relocalisation, and the evidence that a place has to show.
struct RecoveryOptions {
  int min_inliers_recovered = 40;     // matched map points to accept a recovered pose, and those of a second after it
  double min_recovered_share = 0.05;  // share of the map points in view to be matched to accept a recovered pose
  // The same of the points seen from about there before, as a share of those expected to match: where there are several
  // things alike, one of them matches, but its surroundings do not.
  double min_expected_match_ratio = 0.6;
  // A place that matches less: how many of the points in view the image must show by their descriptors, and how evenly,
  // 0 to 1 (matching/shown_points.h; docs/notes/024-places-in-another-light.md). 1: the image is not asked.
  double min_shown_share = 0.68;
};

// The criteria of a key frame, and the points it makes.
struct KeyFrameOptions {
  CloseDepth close_depth;      // up to where a point is close
  int min_close_points = 100;  // close points a frame makes at least (also farther ones), and the need-more bound
  int new_close_points = 70;   // untracked close points that make a key frame worth it
  // Tracked share of the reference key frame's points below which a key frame is due (stereo, RGB-D).
  double key_frame_ratio = 0.75;
  double key_frame_ratio_mono = 0.8;      // the same, monocular (published: 0.9; docs/notes/008-mapping-figures.md)
  double key_frame_all_ratio_mono = 0.5;  // the same of all its points that another key frame observes, monocular
  // Root mean square of the angles by which the translation from the reference key frame moves the tracked points, at
  // which one is due, monocular, radians (docs/notes/019-monocular-scale.md).
  double key_frame_parallax_mono = 0.12;
  // Turn away from the reference key frame's view beyond which one is due, share of the wider angle of view (stereo,
  // RGB-D).
  double key_frame_turn = 0.2;
  int key_frame_min_inliers = 15;   // map points; with fewer no key frame is made
  double key_frame_interval = 1.0;  // seconds after which one may be made though mapping is busy (realtime only)
};

// The beginning of a submap.
struct StartOptions {
  int init_features = 500;         // features of a first frame (stereo, RGB-D)
  int init_min_matches = 100;      // monocular: matches of the two first views
  double init_window = 100;        // pixels, monocular: greatest move of a keypoint between them
  int init_levels = 3;             // greatest pyramid level of the keypoints matched there
  double init_min_parallax = 1.0;  // degrees
  int init_min_points = 50;        // triangulated points of an initial map before adjustment
  double new_map_after = 0.5;      // seconds after a loss at which a new submap is begun beside the old one; 0: never
};

inline constexpr double kFindReadout = -1;  // TrackerOptions::readout that is to be found from the recording

struct TrackerOptions {
  // Rolling shutter: seconds from the exposure of the first row to that of the last; negative where the last comes
  // first. 0: there is none.
  double readout = kFindReadout;
  FirstPoseOptions first_pose;
  LocalMapOptions local_map;
  RecoveryOptions recovery;
  KeyFrameOptions key_frame;
  StartOptions start;
};
Fields fields(TrackerOptions& options);

}  // namespace covis
