// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/options.h"

#include <utility>

namespace covis {

Fields fields(TrackerOptions& o) {
  return {
      {"tracker.motion_window", &o.motion_window, "search round the predicted place, pixels x scale (monocular, RGB-D)",
       1, 200},
      {"tracker.motion_window_stereo", &o.motion_window_stereo, "the same for stereo, pixels x scale", 1, 200},
      {"tracker.motion_min_matches", &o.motion_min_matches, "with fewer matches the search is repeated twice as wide",
       1, 1000},
      {"tracker.motion_min_inliers", &o.motion_min_inliers, "inliers to accept the predicted pose", 4, 1000},
      {"tracker.reference_min_matches", &o.reference_min_matches, "descriptor matches with the reference key frame", 4,
       1000},
      {"tracker.reference_ratio", &o.reference_ratio, "best against second-best descriptor distance there", 0.1, 1},
      {"tracker.local_key_frames", &o.local_key_frames, "key frames whose points make the local map, at most", 1, 1000},
      {"tracker.local_window", &o.local_window, "search round a projected map point, pixels x scale", 0.5, 50},
      {"tracker.local_window_frontal", &o.local_window_frontal,
       "the same for a point seen nearly as before, pixels x scale", 0.5, 50},
      {"tracker.local_window_rgbd", &o.local_window_rgbd, "factor on both windows for RGB-D", 0.5, 10},
      {"tracker.local_ratio", &o.local_ratio, "best against second-best distance at one level", 0.1, 1},
      {"tracker.min_inliers", &o.min_inliers, "matched map points to accept a pose", 4, 1000},
      {"tracker.min_inliers_recovered", &o.min_inliers_recovered, "the same within one second of a recovery", 4, 1000},
      {"tracker.min_recovered_share", &o.min_recovered_share,
       "share of the map points in view that must be matched to accept a recovered pose", 0, 1},
      {"tracker.min_expected_match_ratio", &o.min_expected_match_ratio,
       "the same of those seen from about there before, as a share of what is usually matched", 0, 1},
      {"tracker.new_map_after", &o.new_map_after,
       "seconds after a loss at which a new map is begun beside the old one; 0: never", 0, 1e6},
      {"tracker.close_depth_baselines", &o.close_depth_baselines, "depth up to which a point is close, baselines", 1,
       1000},
      {"tracker.min_close_points", &o.min_close_points, "points a frame makes from depth, at least", 0, 10000},
      {"tracker.new_close_points", &o.new_close_points, "untracked close points that make a key frame worth it", 0,
       10000},
      {"tracker.key_frame_ratio", &o.key_frame_ratio, "tracked share below which a key frame is due (stereo, RGB-D)", 0,
       1},
      {"tracker.key_frame_ratio_mono", &o.key_frame_ratio_mono,
       "tracked share below which a key frame is due (monocular)", 0, 1},
      {"tracker.key_frame_all_ratio_mono", &o.key_frame_all_ratio_mono,
       "the same of all points of two views and more, new ones too (monocular)", 0, 1},
      {"tracker.key_frame_turn", &o.key_frame_turn,
       "turn away from the reference key frame's view beyond which one is due, share of the wider angle of view "
       "(stereo, RGB-D)",
       0.01, 10},
      {"tracker.key_frame_min_inliers", &o.key_frame_min_inliers, "with fewer inliers no key frame is made", 4, 1000},
      {"tracker.key_frame_interval", &o.key_frame_interval,
       "seconds after which a key frame may be made though mapping is busy", 0, 60},
      {"tracker.weak_inliers", &o.weak_inliers,
       "with fewer inliers the next frames get twice the features, until there are 2.5 times as many; 0: never", 0,
       10000},
      {"tracker.init_features", &o.init_features, "features of a first frame (stereo, RGB-D)", 50, 30000},
      {"tracker.init_min_matches", &o.init_min_matches, "matches of the two first views (monocular)", 20, 10000},
      {"tracker.init_window", &o.init_window, "how far a keypoint may move between the two first views, pixels", 5,
       1000},
      {"tracker.init_levels", &o.init_levels, "greatest pyramid level matched there", 0, 31},
      {"tracker.init_min_parallax", &o.init_min_parallax, "parallax of the two first views, degrees", 0.1, 20},
      {"tracker.init_min_points", &o.init_min_points, "points of an initial map", 10, 10000},
  };
}

Fields fields(MapperOptions& o) {
  return {
      {"mapper.create_neighbours", &o.create_neighbours, "key frames to triangulate with (stereo, RGB-D)", 1, 100},
      {"mapper.create_neighbours_mono", &o.create_neighbours_mono, "key frames to triangulate with (monocular)", 1,
       100},
      {"mapper.min_found_ratio", &o.min_found_ratio, "found / visible below which a recent point is erased", 0, 1},
      {"mapper.fuse_second_neighbours", &o.fuse_second_neighbours, "neighbours of each neighbour that join fusion", 0,
       50},
      {"mapper.fuse_window", &o.fuse_window, "search window of fusion, pixels x scale", 0.5, 50},
      {"mapper.ba_key_frames", &o.ba_key_frames, "key frames that move in local bundle adjustment, at most", 1, 1000},
      {"mapper.ba_fixed_key_frames", &o.ba_fixed_key_frames, "key frames that hold it, at most", 1, 1000},
      {"mapper.ba_iterations_first", &o.ba_iterations_first, "iterations before outliers are dropped", 1, 100},
      {"mapper.ba_iterations_second", &o.ba_iterations_second, "iterations after", 0, 100},
      {"mapper.refine_focal", &o.refine_focal, "monocular, RGB-D: adjust the focal length too, when the map tells it"},
      {"mapper.cull_redundancy", &o.cull_redundancy,
       "share of points seen by three others that makes a key frame redundant", 0, 1},
  };
}

Fields fields(LoopOptions& o) {
  return {
      {"loop.close", &o.close, "close loops (needs a vocabulary)"},
      {"loop.min_matches", &o.min_matches, "matches of points of both places", 3, 1000},
      {"loop.min_inliers", &o.min_inliers, "of them that agree with a similarity", 3, 1000},
      {"loop.min_found", &o.min_found, "points of the old place found in the new view", 3, 10000},
      {"loop.min_found_share", &o.min_found_share, "the same as a share of those in view", 0, 1},
      {"loop.max_drift", &o.max_drift, "greatest correction as a share of the path since (stereo, RGB-D)", 0, 100},
      {"loop.max_drift_mono", &o.max_drift_mono, "the same, monocular", 0, 100},
      {"loop.max_rotation", &o.max_rotation, "greatest correction of orientation, degrees", 0, 180},
      {"loop.max_scale", &o.max_scale, "greatest change of scale, a factor", 1, 100},
      {"loop.merge_min_found", &o.merge_min_found, "loop.min_found to join two maps", 3, 10000},
      {"loop.merge_min_found_share", &o.merge_min_found_share, "loop.min_found_share to join two maps", 0, 1},
      {"loop.ba_iterations", &o.ba_iterations, "iterations of the full bundle adjustment after a loop; 0: none", 0,
       100},
      {"loop.ba_key_frames", &o.ba_key_frames, "key frames after which its result is taken over", 1, 100},
  };
}

Fields fields(SystemOptions& o) {
  Fields all = fields(o.orb);
  for (Field& field : fields(o.tracker)) all.push_back(std::move(field));
  for (Field& field : fields(o.mapper)) all.push_back(std::move(field));
  for (Field& field : fields(o.loop)) all.push_back(std::move(field));
  all.push_back(
      {"system.mapping_delay", &o.mapping_delay,
       "frames after a key frame at which its mapping becomes visible to tracking, unless few points are left", 1,
       100});
  all.push_back({"system.realtime", &o.realtime, "frames at their own times, mapping visible when ready"});
  all.push_back({"system.localize", &o.localize, "localisation only: no key frames, no points; needs a map"});
  all.push_back({"system.seed", &o.seed, "of the random choices", 0, 2147483647.0});
  return all;
}

}  // namespace covis
