// SPDX-License-Identifier: Apache-2.0
// Settings of loop closing, each with its default, unit and meaning (algorithms.md §5).
#pragma once

#include "covis/core/fields.h"
#include "covis/core/sensor.h"

namespace covis {

struct LoopOptions {
  bool close = true;                    // close loops (needs a vocabulary)
  int min_matches = 20;                 // by descriptor, of points of both places
  int min_inliers = 20;                 // that agree with a similarity
  int min_found = 40;                   // points of the old place found in the new view
  double min_found_share = 0.15;        // the same as a share of those in view
  double max_drift = 0.1;               // greatest correction by how far the scene moved past since (stereo, RGB-D)
  double max_drift_mono = 0.3;          // greatest correction, as a share of the path travelled since (monocular)
  double max_rotation = 45;             // greatest correction of orientation, degrees
  double max_scale = 3;                 // greatest change of scale, a factor
  int weak_link = 60;                   // points seen before and after a key frame: with fewer the path bounds no drift
  int merge_min_found = 50;             // min_found to join two submaps, of whose relation nothing else is known
  double merge_min_found_share = 0.25;  // min_found_share, likewise
  int ba_iterations = 10;               // iterations of the full bundle adjustment after a loop
  int ba_key_frames = 5;                // key frames after which its result is applied

  double drift(Sensor sensor) const { return sensor == Sensor::monocular ? max_drift_mono : max_drift; }
};
Fields fields(LoopOptions& options);
// Those that merging maps asks for: between maps there is no drift, and nothing goes on meanwhile.
Fields merge_fields(LoopOptions& options);

}  // namespace covis
