// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/mapper_options.h"

namespace covis {

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
      {"mapper.refine_distortion", &o.refine_distortion,
       "monocular, camera given without distortion: find what distortion its images have, when the map tells it; "
       "stereo: "
       "what rectification left in the right image's columns"},
      {"mapper.register_depth", &o.register_depth,
       "RGB-D: find how depth images are registered to images, when the map tells that they are not"},
      {"mapper.estimate_depth_noise", &o.estimate_depth_noise,
       "RGB-D: estimate the noise of depth from the map, when the camera says nothing of it"},
      {"mapper.cull_redundancy", &o.cull_redundancy,
       "share of points seen by three others that makes a key frame redundant", 0, 1},
      {"mapper.max_map_mb", &o.max_map_mb,
       "MB that the map may take before it is thinned where that costs least; 0: no bound", 0, 1'000'000},
  };
}

}  // namespace covis
