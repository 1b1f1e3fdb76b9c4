// SPDX-License-Identifier: Apache-2.0
// The focal length of a monocular or RGB-D map: when the map is asked for it, and what is believed. A camera that turns
// and moves tells its focal length; a wrong one makes a monocular scale drift at every turn, and motion by depth too
// long or too short. What was measured: docs/results.md, "The focal length".
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "covis/map/map.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

// It is asked for again as the map grows, until the map is large.
class FocalSchedule {
 public:
  static constexpr int kIterations = 20;  // of bundle adjustment before it is asked for

  // When it is to be asked for now: the number of key frames after which what comes of it is taken over.
  std::optional<int> ask(const Map& map);
  // The map is begun anew.
  void restart(const Map& map) { next_ = map.next_serial() + kFirst; }

 private:
  static constexpr uint32_t kFirst = 20;                     // serial of the key frame at which it is first asked for
  static constexpr uint32_t kLeastStep = 5, kStepShare = 4;  // key frames to the next time: a share of those made
  static constexpr int kLeastAge = 2, kAgeShare = 25;        // key frames it is given: more in a larger map
  static constexpr size_t kLargest = 100;                    // key frames of a map

  uint32_t next_ = kFirst;
};

// Moves an adjusted problem to its best focal length, in a few steps of at most 2 % as an estimate is good only near:
// each when it is known well, surely another one, within bounds of the given one, and the cost really falls. False: the
// problem stays as it was.
bool refine_focal(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx,
                  const std::atomic<bool>* interrupt = nullptr);

}  // namespace covis
