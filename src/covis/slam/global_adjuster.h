// SPDX-License-Identifier: Apache-2.0
// Full bundle adjustment after a loop, in its own thread on a copy of the map; mapping goes on meanwhile. The mapping
// thread starts it, takes its result over (what was made meanwhile is moved along the spanning tree), or gives it up when
// another loop comes. Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, section III-D.
#pragma once

#include <atomic>
#include <thread>

#include "covis/map/shared_map.h"
#include "covis/slam/map_problem.h"

namespace covis {

class GlobalAdjuster {
 public:
  ~GlobalAdjuster() { abandon(); }

  // Copies the part of the map that the key frame belongs to, under a read guard, and begins.
  void start(const SharedMap& map, KeyFrameId of_part, int iterations);
  bool running() const { return thread_.joinable(); }
  // The result is there: commit() will not wait.
  bool ready() const { return done_.load(); }
  // Waits for the result and writes it to the map. Returns the milliseconds the adjustment took.
  double commit(SharedMap& map);
  // Interrupts and forgets.
  void abandon();

 private:
  void take_over(Map& map) const;

  MapProblem problem_;  // of the thread while running
  BundleSummary summary_;
  double ms_ = 0;
  std::atomic<bool> interrupt_{false}, done_{false};
  std::thread thread_;
};

}  // namespace covis
