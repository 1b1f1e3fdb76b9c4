// SPDX-License-Identifier: Apache-2.0
// Full bundle adjustment after a loop, in its own thread on a copy of the map; mapping goes on meanwhile. The mapping
// thread starts it, takes its result over (what was made meanwhile is moved along the spanning tree), or gives it up when
// another loop comes. Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, section III-D.
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "covis/map/shared_map.h"
#include "covis/slam/map_problem.h"

namespace covis {

class GlobalAdjuster {
 public:
  ~GlobalAdjuster() { abandon(); }

  // Copies the part of the map that the key frame belongs to, under a read guard, and begins.
  void start(const SharedMap& map, KeyFrameId of_part, int iterations);
  // The same with the focal length among what is adjusted, as far as the map tells it; within 5 % of given_fx. Where it
  // does not, or agrees with what it is, nothing comes of it.
  void start_focal(const SharedMap& map, KeyFrameId of_part, double given_fx);
  bool running() const { return thread_.joinable(); }
  // The result is there: commit() will not wait.
  bool ready() const { return done_.load(); }
  // Waits for the result and writes it to the map. Returns the milliseconds the adjustment took.
  double commit(SharedMap& map);
  // The camera that the last commit() gave to the map, if it did.
  const std::optional<Pinhole>& refined_camera() const { return camera_; }
  bool refines_focal() const { return given_fx_ > 0; }
  // Interrupts and forgets.
  void abandon();

 private:
  void begin(const SharedMap& map, KeyFrameId of_part, int iterations);
  void adjust(int iterations);
  bool refine_focal(BundleAdjuster& adjuster);
  void take_over(Map& map) const;

  MapProblem problem_;  // of the thread while running
  BundleSummary summary_;
  double given_fx_ = 0;  // positive: the focal length is asked for
  std::optional<Pinhole> camera_;
  double ms_ = 0;
  std::atomic<bool> interrupt_{false}, done_{false};
  std::thread thread_;
};

}  // namespace covis
