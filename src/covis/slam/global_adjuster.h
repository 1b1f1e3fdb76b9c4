// SPDX-License-Identifier: Apache-2.0
// Full bundle adjustment after a loop, or of a map with its focal length, in its own thread on a copy of the map;
// mapping goes on meanwhile. The mapping thread starts it, takes its result over (what was made meanwhile is moved
// along the spanning tree), or gives it up when a loop comes. Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017,
// section III-D.
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

  // Copies the submap that the key frame belongs to, under a read guard, and begins. With `given_fx`, the
  // focal length the camera came with, that is adjusted too (focal_refinement.h); where the map does not tell it, or
  // agrees with what it is, nothing comes of it.
  void start(const SharedMap& map, KeyFrameId of_submap, int iterations, std::optional<double> given_fx = {});
  bool running() const { return thread_.joinable(); }
  // The result is there: commit() will not wait.
  bool ready() const { return done_.load(); }

  struct Outcome {
    bool focal = false;       // it was asked for the focal length
    bool taken_over = false;  // the map was changed (and, asked for it, its camera)
    double ms = 0;            // that the adjustment took
  };
  // Waits for the result and writes it to the map.
  Outcome commit(SharedMap& map);
  // Interrupts and forgets.
  void abandon();

 private:
  void adjust(int iterations);
  bool take_over(Map& map) const;

  MapProblem problem_;  // of the thread while running
  std::optional<double> given_fx_;
  bool good_ = false;  // there is something to take over
  double ms_ = 0;
  std::atomic<bool> interrupt_{false}, done_{false};
  std::thread thread_;
};

}  // namespace covis
