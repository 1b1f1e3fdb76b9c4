// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of the key frames around a new one, on a copy.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI-D; Mur-Artal and Tardós, "ORB-SLAM2", T-RO
// 2017, section III-C.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "covis/map/shared_map.h"
#include "covis/mapping/depth_noise_tracker.h"
#include "covis/mapping/mapper_options.h"
#include "covis/mapping/mapping_report.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

struct LocalWindow {
  std::vector<KeyFrameId> key_frames;  // those that move first
  size_t moving = 0;                   // how many of them move; the others see their points and hold them
};

// These key frames move; the others that share points with them hold them, those that share most first (`fixed` of
// them, at most).
LocalWindow window_around(const Map& map, std::vector<KeyFrameId> moving, int fixed);

// The same of a key frame and its best covisible ones (`moving` in all, at most).
LocalWindow local_window(const Map& map, KeyFrameId current, int moving, int fixed);

// The noise seen in the adjusted problem goes to `depth_noise` (null: nobody asks). `interrupt` (may be
// null) cuts it short when it becomes true.
AdjustmentReport adjust_locally(SharedMap& map, KeyFrameId current, const MapperOptions& options,
                                BundleAdjuster& adjuster, DepthNoiseTracker* depth_noise,
                                const std::atomic<bool>* interrupt);

}  // namespace covis
