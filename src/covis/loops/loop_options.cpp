// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_options.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace covis {

Fields fields(LoopOptions& o) {
  return {
      {"loop.close", &o.close, "close loops (needs a vocabulary)"},
      {"loop.min_matches", &o.min_matches, "matches of points of both places", 3, 1000},
      {"loop.min_inliers", &o.min_inliers, "of them that agree with a similarity", 3, 1000},
      {"loop.min_found", &o.min_found, "points of the old place found in the new view", 3, 10000},
      {"loop.min_found_share", &o.min_found_share, "the same as a share of those in view", 0, 1},
      {"loop.max_drift", &o.max_drift,
       "greatest correction as a share of how far the scene moved past since (stereo, RGB-D)", 0, 100},
      {"loop.max_drift_mono", &o.max_drift_mono, "greatest correction as a share of the path since (monocular)", 0,
       100},
      {"loop.max_rotation", &o.max_rotation, "greatest correction of orientation, degrees", 0, 180},
      {"loop.max_scale", &o.max_scale, "greatest change of scale, a factor", 1, 100},
      {"loop.weak_link", &o.weak_link,
       "where fewer points are seen both before and after a key frame, the path bounds no drift, if two places agree; "
       "0: it always does",
       0, 10000},
      {"loop.merge_min_found", &o.merge_min_found, "loop.min_found to join two submaps", 3, 10000},
      {"loop.merge_min_found_share", &o.merge_min_found_share, "loop.min_found_share to join two submaps", 0, 1},
      {"loop.ba_iterations", &o.ba_iterations, "iterations of the full bundle adjustment after a loop; 0: none", 0,
       100},
      {"loop.ba_key_frames", &o.ba_key_frames, "key frames after which its result is applied", 1, 100},
  };
}

Fields merge_fields(LoopOptions& options) {
  constexpr std::array<std::string_view, 7> kAskedFor = {
      "loop.min_matches",     "loop.min_inliers",           "loop.min_found",    "loop.min_found_share",
      "loop.merge_min_found", "loop.merge_min_found_share", "loop.ba_iterations"};
  Fields known = fields(options);
  std::erase_if(known, [&](const Field& field) { return std::ranges::find(kAskedFor, field.name) == kAskedFor.end(); });
  return known;
}

}  // namespace covis
