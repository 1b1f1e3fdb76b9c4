// SPDX-License-Identifier: Apache-2.0
// The camera of a monocular or RGB-D map: when the map is asked for it, and which answer is believed. A camera that
// turns and moves tells its focal length, and what distortion its lens has that was not given. Either, when wrong,
// makes a monocular scale drift at every turn, and motion by depth too long or too short. Measured figures:
// docs/notes/002-focal-length.md, 020-focal-length-only-where-it-is-sure.md and 050-distortion-that-was-left.md.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "covis/core/sensor.h"
#include "covis/loops/background_adjustment.h"
#include "covis/mapping/map_problem.h"

namespace covis {

// The map is asked for it again as it grows, until it is large.
class RefinementSchedule {
 public:
  explicit RefinementSchedule(Sensor sensor = Sensor::monocular)
      : pace_(sensor == Sensor::stereo ? kPaceOfStereo : Pace()) {}
  // When the map is to be asked now: the number of key frames after which the answer is applied.
  std::optional<int> ask(const Map& map);
  // The map is begun anew.
  void restart(const Map& map) { next_ = map.next_serial() + pace_.first; }

 private:
  struct Pace {
    uint32_t first = 20;   // serial of the key frame at which it is first asked for
    double more = 0.25;    // key frames to the next time, as a share of those made
    size_t largest = 100;  // key frames of a map
  };
  static constexpr Pace kPaceOfStereo{.first = 8, .more = 0.6, .largest = 60};
  static constexpr uint32_t kLeastStep = 5;
  static constexpr int kLeastAge = 2, kAgeShare = 25;  // key frames it is given: more in a larger map

  Pace pace_;
  uint32_t next_ = pace_.first;
};

// Which of a camera's parameters may be refined.
struct RefinableCamera {
  double given_fx = 0;  // focal length that the camera came with, pixels
  bool focal = true;
  bool distortion = false;  // for a monocular camera that was given without any
};

// Moves an adjusted problem to its best focal length, in a few steps of at most 2 % as an estimate is good only near:
// each when it is known well, surely another one whatever part of the map and axis of the image is asked, within bounds
// of the given one, and the cost really falls. False: the problem stays as it was.
bool refine_focal(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx,
                  const std::atomic<bool>* interrupt = nullptr);

// Bundle adjustment of a submap with the camera: with its residual distortion where that shows, otherwise with its
// focal length. Its result is applied to a map of one submap alone, and to its camera and keypoints, as the other
// submaps would have to follow.
class CameraRefinement : public AdjustmentJob {
 public:
  // Null when there is nothing to adjust.
  static std::unique_ptr<CameraRefinement> of(const Map& map, KeyFrameId key_frame, const RefinableCamera& refinable);

  AdjustmentKind kind() const override { return AdjustmentKind::camera; }
  bool run(const std::atomic<bool>& interrupt) override;
  std::optional<KeyFrameMoves> apply(SharedMap& map) const override;

 private:
  CameraRefinement(MapProblem submap, const RefinableCamera& refinable)
      : submap_(std::move(submap)), refinable_(refinable) {}

  MapProblem submap_;
  const RefinableCamera refinable_;
};

}  // namespace covis
