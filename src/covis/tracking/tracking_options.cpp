// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/tracking_options.h"

namespace covis {

Fields fields(TrackerOptions& o) {
  return {
      {"tracker.motion_window", &o.first_pose.motion_window, "search around the predicted place, pixels x scale (monocular, RGB-D)",
       1, 200},
      {"tracker.motion_window_stereo", &o.first_pose.motion_window_stereo, "the same for stereo, pixels x scale", 1, 200},
      {"tracker.motion_min_matches", &o.first_pose.motion_min_matches, "with fewer matches the search is repeated twice as wide",
       1, 1000},
      {"tracker.motion_min_inliers", &o.first_pose.motion_min_inliers, "inliers to accept the predicted pose", 4, 1000},
      {"tracker.reference_min_matches", &o.first_pose.reference_min_matches, "descriptor matches with the reference key frame", 4,
       1000},
      {"tracker.reference_ratio", &o.first_pose.reference_ratio, "best against second-best descriptor distance there", 0.1, 1},
      {"tracker.local_key_frames", &o.local_map.local_key_frames, "key frames whose points make the local map, at most", 1, 1000},
      {"tracker.local_window", &o.local_map.local_window, "search around a projected map point, pixels x scale", 0.5, 50},
      {"tracker.local_window_frontal", &o.local_map.local_window_frontal,
       "the same for a point seen nearly as before, pixels x scale", 0.5, 50},
      {"tracker.local_window_rgbd", &o.local_map.local_window_rgbd, "factor on both windows for RGB-D", 0.5, 10},
      {"tracker.local_ratio", &o.local_map.local_ratio, "best against second-best distance at one level", 0.1, 1},
      {"tracker.min_inliers", &o.local_map.min_inliers, "matched map points to accept a pose", 4, 1000},
      {"tracker.min_inliers_recovered", &o.recovery.min_inliers_recovered, "the same within one second of a recovery", 4, 1000},
      {"tracker.min_recovered_share", &o.recovery.min_recovered_share,
       "share of the map points in view that must be matched to accept a recovered pose", 0, 1},
      {"tracker.min_expected_match_ratio", &o.recovery.min_expected_match_ratio,
       "the same of those seen from about there before, as a share of as many as are expected to match", 0, 1,
       "tracker.min_usual_share"},
      {"tracker.new_map_after", &o.start.new_map_after,
       "seconds after a loss at which a new map is begun beside the old one; 0: never", 0, 1e6},
      {"tracker.close_depth_baselines", &o.key_frame.close_depth_baselines, "depth up to which a point is close, baselines", 1,
       1000},
      {"tracker.min_close_points", &o.key_frame.min_close_points, "points a frame makes from depth, at least", 0, 10000},
      {"tracker.new_close_points", &o.key_frame.new_close_points, "untracked close points that make a key frame worth it", 0,
       10000},
      {"tracker.key_frame_ratio", &o.key_frame.key_frame_ratio, "tracked share below which a key frame is due (stereo, RGB-D)", 0,
       1},
      {"tracker.key_frame_ratio_mono", &o.key_frame.key_frame_ratio_mono,
       "tracked share below which a key frame is due (monocular)", 0, 1},
      {"tracker.key_frame_all_ratio_mono", &o.key_frame.key_frame_all_ratio_mono,
       "the same of all points of two views and more, new ones too (monocular)", 0, 1},
      {"tracker.key_frame_turn", &o.key_frame.key_frame_turn,
       "turn away from the reference key frame's view beyond which one is due, share of the wider angle of view "
       "(stereo, RGB-D)",
       0.01, 10},
      {"tracker.key_frame_min_inliers", &o.key_frame.key_frame_min_inliers, "with fewer inliers no key frame is made", 4, 1000},
      {"tracker.key_frame_interval", &o.key_frame.key_frame_interval,
       "seconds after which a key frame may be made though mapping is busy", 0, 60},
      {"tracker.weak_inliers", &o.local_map.weak_inliers,
       "with fewer inliers the next frames get twice the features, until there are 2.5 times as many; 0: never", 0,
       10000},
      {"tracker.init_features", &o.start.init_features, "features of a first frame (stereo, RGB-D)", 50, 30000},
      {"tracker.init_min_matches", &o.start.init_min_matches, "matches of the two first views (monocular)", 20, 10000},
      {"tracker.init_window", &o.start.init_window, "how far a keypoint may move between the two first views, pixels", 5,
       1000},
      {"tracker.init_levels", &o.start.init_levels, "greatest pyramid level matched there", 0, 31},
      {"tracker.init_min_parallax", &o.start.init_min_parallax, "parallax of the two first views, degrees", 0.1, 20},
      {"tracker.init_min_points", &o.start.init_min_points, "points of an initial map", 10, 10000},
  };
}

}  // namespace covis
