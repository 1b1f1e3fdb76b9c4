// SPDX-License-Identifier: Apache-2.0
// The back end: conducts mapping, loop closing and the adjustments in the background for each key frame. Synchronous,
// and the only one that changes key frames and points while frames are tracked; its thread is in mapping_actor.h.
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "covis/core/schedule.h"
#include "covis/loops/background_adjustment.h"
#include "covis/loops/camera_refinement.h"
#include "covis/loops/loop_closer.h"
#include "covis/loops/loop_options.h"
#include "covis/loops/registration_refinement.h"
#include "covis/map/shared_map.h"
#include "covis/mapping/depth_against_motion.h"
#include "covis/mapping/mapper.h"
#include "covis/slam/messages.h"
#include "covis/slam/options.h"

namespace covis {

// The slices of the settings that the back end reads.
struct BackendOptions {
  Sensor sensor = Sensor::monocular;
  MapperOptions mapper;
  LoopOptions loop;
  TrackerOptions tracker;  // for points close enough, and for frames located afterwards
  int seed = 0;            // seed of the random choices
  Schedule schedule = Schedule::deterministic;

  explicit BackendOptions(const SystemOptions& options);
};

class Backend {
 public:
  // The map has the camera it was given. Without a vocabulary (null) places are not recognised.
  Backend(SharedMap& map, const BackendOptions& options, std::shared_ptr<const Vocabulary> vocabulary = nullptr);

  // Maps the key frame, applies the background's result when it is due, looks for a loop, asks for the camera
  // when it is time, and locates earlier frames that the request brings. `interrupt` (may be null) becomes true when
  // another waits.
  MappingReport process(const KeyFrameRequest& request, const std::atomic<bool>* interrupt);
  MappingReport initialise(const InitialMapRequest& request);
  void discard(uint32_t submap);
  void forget_erased(uint64_t count) { map_.write()->forget_erased(count); }
  // Waits for the job in the background and applies its result. Returns how that moved key frames.
  KeyFrameMoves finish();

 private:
  void apply_adjustment(MappingReport& report);
  BackgroundAdjustment::Outcome finish_adjustment();
  void close_loop(MappingReport& report);
  void refine_camera(KeyFrameId current);
  bool adjusts_shutter(const KeyFrameRequest& request);
  bool registers_depth(KeyFrameId current);
  std::vector<DepthAgainstMotion> check_depth(KeyFrameId current, MotionDepthCheck::Pace pace);
  void forget_replaced_points(KeyFrameId current);
  int keep_within_bound(KeyFrameId current);

  SharedMap& map_;
  const BackendOptions options_;
  Mapper mapper_;
  LoopCloser closer_;
  BackgroundAdjustment background_;
  RefinementSchedule refinement_{options_.sensor};
  RegistrationSchedule registration_;
  MotionDepthCheck depth_check_;
  const Pinhole given_;  // the camera as it came
  struct Told {
    bool thins = false, out_of_reach = false;
  };
  Told told_;  // warnings about the bound of the map that were logged
};

}  // namespace covis
