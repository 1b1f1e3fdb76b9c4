// SPDX-License-Identifier: Apache-2.0
// Settings of local mapping, each with its default, unit and meaning: the published ones where no other source is named
// (Mur-Artal, Montiel, Tardós, T-RO 2015; Mur-Artal and Tardós, T-RO 2017; algorithms.md §4).
#pragma once

#include "covis/core/fields.h"
#include "covis/core/sensor.h"

namespace covis {

struct MapperOptions {
  int create_neighbours = 10;        // covisible key frames to triangulate with (stereo, RGB-D)
  int create_neighbours_mono = 20;   // the same, monocular
  double min_found_ratio = 0.25;     // found / visible below which a recent point is erased
  int fuse_second_neighbours = 5;    // neighbours of each neighbour that join fusion
  double fuse_window = 3;            // pixels x scale
  int ba_key_frames = 20;            // key frames that move in local bundle adjustment, at most
  int ba_fixed_key_frames = 40;      // key frames that hold it, at most
  int ba_iterations_first = 5;       // before outliers are dropped
  int ba_iterations_second = 10;     // after
  bool refine_focal = true;          // monocular, RGB-D: the focal length too (docs/notes/002-focal-length.md)
  bool refine_distortion = true;     // monocular, given without distortion: what distortion images have (note 050);
                                     // stereo: what rectification left in the right image's columns (note 063)
  bool register_depth = true;        // RGB-D: find where depth images show what images show (note 052)
  bool estimate_depth_noise = true;  // RGB-D: when the camera says nothing of it (docs/notes/018-depth-noise.md)
  double cull_redundancy = 0.9;      // share of points seen by three others that makes a key frame redundant
  int max_map_mb = 0;                // greatest size of the map (mapping/map_limit.h); 0: no bound

  int neighbours(Sensor sensor) const {
    return sensor == Sensor::monocular ? create_neighbours_mono : create_neighbours;
  }
};
Fields fields(MapperOptions& options);

}  // namespace covis
