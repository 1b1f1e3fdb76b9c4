// SPDX-License-Identifier: Apache-2.0
// Settings of tracking and mapping, each with its default, unit and meaning. Figures without another source are the
// published ones (Mur-Artal, Montiel, Tardós, T-RO 2015; Mur-Artal and Tardós, T-RO 2017; algorithms.md §3 and §4).
#pragma once

#include "covis/core/fields.h"
#include "covis/core/sensor.h"
#include "covis/features/frontend.h"

namespace covis {

struct TrackerOptions {
  double motion_window = 15;          // pixels x scale: search round the predicted place (monocular, RGB-D)
  double motion_window_stereo = 7;    // the same, stereo
  int motion_min_matches = 20;        // fewer: search again in windows twice as wide
  int motion_min_inliers = 10;        // to accept the pose of the motion model or the reference key frame
  int reference_min_matches = 15;     // descriptor matches with the reference key frame
  double reference_ratio = 0.7;       // best against second-best descriptor distance there
  int local_key_frames = 80;          // key frames whose points make the local map, at most
  double local_window = 4;            // pixels x scale: search round a projected map point …
  double local_window_frontal = 2.5;  // … seen nearly as before (cosine above 0.998)
  double local_window_rgbd = 3;       // factor on both for RGB-D
  double local_ratio = 0.8;           // best against second-best distance when both are of one level
  int min_inliers = 30;               // matched map points to accept a pose
  int min_inliers_recovered = 40;     // the same within one second of a recovery
  double min_recovered_share = 0.05;  // of the map points in view that must be matched to accept a recovered pose
  double min_expected_match_ratio = 0.6;       // and of those seen from about there before, of as many as usually are: things of
                                      // which there are several alike match, what stands round them does not
  double new_map_after = 2;           // seconds after a loss at which a new map is begun beside the old one; 0: never
  double close_depth_baselines = 40;  // depth in baselines up to which a point is close
  int min_close_points = 100;  // close points a frame makes at least (also farther ones), and the need-more bound
  int new_close_points = 70;   // untracked close points that make a key frame worth it
  double key_frame_ratio =
      0.75;  // tracked share of the reference key frame's points below which one is due (stereo, RGB-D)
  double key_frame_ratio_mono = 0.8;      // the same, monocular (published: 0.9; see docs/results.md)
  double key_frame_all_ratio_mono = 0.5;  // the same of all its points that another key frame observes, monocular
  double key_frame_turn = 0.2;      // turn away from the reference key frame's view beyond which one is due, share of
                                    // the wider angle of view (stereo, RGB-D)
  int key_frame_min_inliers = 15;   // with fewer no key frame is made
  double key_frame_interval = 1.0;  // seconds after which one may be made though mapping is busy
  int weak_inliers = 80;           // with fewer inliers the next frames get twice the features, until 2.5 times as many
  int init_features = 500;         // features of a first frame (stereo, RGB-D)
  int init_min_matches = 100;      // monocular: matches of the two first views
  double init_window = 100;        // pixels, monocular: how far a keypoint may move between them
  int init_levels = 3;             // greatest pyramid level of the keypoints matched there
  double init_min_parallax = 1.0;  // degrees
  int init_min_points = 50;        // triangulated points of an initial map before adjustment
};
Fields fields(TrackerOptions& options);

struct MapperOptions {
  int create_neighbours = 10;       // covisible key frames to triangulate with (stereo, RGB-D)
  int create_neighbours_mono = 20;  // the same, monocular
  double min_found_ratio = 0.25;    // found / visible below which a recent point is erased
  int fuse_second_neighbours = 5;   // neighbours of each neighbour that join fusion
  double fuse_window = 3;           // pixels x scale
  int ba_key_frames = 20;           // key frames that move in local bundle adjustment, at most
  int ba_fixed_key_frames = 40;     // key frames that hold it, at most
  int ba_iterations_first = 5;      // before outliers are dropped
  int ba_iterations_second = 10;    // after
  bool refine_focal = true;         // monocular, RGB-D: the focal length too, when the map tells it (docs/results.md)
  double cull_redundancy = 0.9;     // share of points seen by three others that makes a key frame redundant
};
Fields fields(MapperOptions& options);

struct LoopOptions {
  bool close = true;                    // close loops (needs a vocabulary)
  int min_matches = 20;                 // by descriptor, of points of both places
  int min_inliers = 20;                 // that agree with a similarity
  int min_found = 40;                   // of the old place's points found in the new view
  double min_found_share = 0.15;        // of those in view
  double max_drift = 0.1;               // greatest correction, as a share of the path travelled since (stereo, RGB-D)
  double max_drift_mono = 0.3;          // the same, monocular
  double max_rotation = 45;             // greatest correction of orientation, degrees
  double max_scale = 3;                 // greatest change of scale, a factor
  int merge_min_found = 50;             // min_found to join two maps, of whose relation nothing else is known
  double merge_min_found_share = 0.25;  // min_found_share, likewise
  int ba_iterations = 10;               // of the full bundle adjustment after a loop
  int ba_key_frames = 5;                // key frames after which its result is taken over
};
Fields fields(LoopOptions& options);

struct SystemOptions {
  Sensor sensor = Sensor::monocular;
  OrbOptions orb;
  TrackerOptions tracker;
  MapperOptions mapper;
  LoopOptions loop;
  // Frames after a key frame at which what mapping made of it becomes visible to tracking; sooner near a loss.
  int mapping_delay = 2;
  bool realtime = false;  // instead: as soon as it is ready; mapping is interrupted by new key frames
  bool localize = false;  // localisation only: the map is not touched (algorithms.md §3.7)
  int seed = 0;           // of the random choices
};
Fields fields(SystemOptions& options);

}  // namespace covis
