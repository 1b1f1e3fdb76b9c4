// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/backend.h"

#include <optional>
#include <string>
#include <utility>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/loops/columns_refinement.h"
#include "covis/loops/shutter_adjustment.h"
#include "covis/loops/submap_adjustment.h"
#include "covis/mapping/map_limit.h"
#include "covis/tracking/backtrack.h"

namespace covis {

BackendOptions::BackendOptions(const SystemOptions& options)
    : sensor(options.sensor),
      mapper(options.mapper),
      loop(options.loop),
      tracker(options.tracker),
      seed(options.seed),
      schedule(options.schedule()) {}

Backend::Backend(SharedMap& map, const BackendOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
    : map_(map),
      options_(options),
      mapper_(map, options.sensor, options.mapper, options.tracker.key_frame.close_depth, std::move(vocabulary)),
      closer_(map, options.sensor, options.loop, options.seed),
      given_(map.read()->camera()) {}

MappingReport Backend::process(const KeyFrameRequest& request, const std::atomic<bool>* interrupt) {
  const Stopwatch total;
  MappingReport report{mapper_.process(request, interrupt), {}, {}};
  if (!report.key_frame.valid()) return report;
  const Stopwatch watch;
  apply_adjustment(report);
  close_loop(report);
  if (!request.doubted_depth && !adjusts_shutter(request)) refine_camera(report.key_frame);
  if (!background_.running()) RegistrationSchedule::drop_depths(map_);
  forget_replaced_points(report.key_frame);
  report.loop_ms = watch.ms();
  report.counts.key_frames_thinned = keep_within_bound(report.key_frame);
  using Pace = MotionDepthCheck::Pace;
  if (!interrupt || !*interrupt)
    report.depth_checks = check_depth(report.key_frame, request.suspected_depth ? Pace::every_view : Pace::usual);
  report.earlier = backtrack(map_, {options_.sensor, options_.tracker, options_.seed}, request.unlocated);
  report.total_ms = total.ms();
  return report;
}

MappingReport Backend::initialise(const InitialMapRequest& request) { return {mapper_.initialise(request), {}, {}}; }

// A fixed number of key frames after its start, so that the result does not depend on how fast the machine is; in real
// time with the first key frame after it is there.
void Backend::apply_adjustment(MappingReport& report) {
  if (!background_.running()) return;
  background_.count_key_frame();
  if (options_.schedule == Schedule::realtime ? !background_.ready() : !background_.due()) return;
  BackgroundAdjustment::Outcome outcome = finish_adjustment();
  if (outcome.kind == AdjustmentKind::full) report.full_adjustment_ms = outcome.ms;
  report.moves = std::move(outcome.moves);
}

BackgroundAdjustment::Outcome Backend::finish_adjustment() {
  BackgroundAdjustment::Outcome outcome = background_.apply(map_);
  if (outcome.kind == AdjustmentKind::full && !outcome.solved)
    log(LogLevel::warning, "the full bundle adjustment after a loop failed; the map stays as it was");
  return outcome;
}

// A loop makes the job in the background out of date.
void Backend::close_loop(MappingReport& report) {
  if (!options_.loop.close) return;
  report.loop = closer_.process(report.key_frame);
  if (!report.loop.changed_map()) return;
  background_.abandon();
  if (options_.loop.ba_iterations == 0) return;
  auto job = FullAdjustment::of(*map_.read(), report.key_frame, options_.loop.ba_iterations);
  background_.start(std::move(job), options_.loop.ba_key_frames);
}

void Backend::refine_camera(KeyFrameId current) {
  const MapperOptions& o = options_.mapper;
  const bool stereo = options_.sensor == Sensor::stereo;
  if (background_.running() || registers_depth(current)) return;
  if (!o.refine_distortion && (stereo || !o.refine_focal)) return;
  const std::optional<int> key_frames = refinement_.ask(*map_.read());
  if (!key_frames) return;
  // With another focal length stereo's baseline would have to follow.
  if (stereo) return background_.start(ColumnsRefinement::of(*map_.read(), current), *key_frames);
  auto job = CameraRefinement::of(*map_.read(), current, {given_.fx, o.refine_focal, o.refine_distortion});
  background_.start(std::move(job), *key_frames);
}

// True: the map is asked for the registration of its depths.
bool Backend::registers_depth(KeyFrameId current) {
  constexpr int kKeyFrames = 2;  // after which the answer is applied
  if (!options_.mapper.register_depth || !registration_.ask(*map_.read())) return false;
  background_.start(
      RegistrationRefinement::of(*map_.read(), current, {given_.fx, options_.mapper.estimate_depth_noise}), kKeyFrames);
  return true;
}

// True: the camera has another rolling shutter, and the map is being adjusted to it.
bool Backend::adjusts_shutter(const KeyFrameRequest& request) {
  if (!request.shutter || background_.running()) return false;
  const auto map = map_.read();
  // A request that was on its way while the map was adjusted says nothing of its camera now.
  if (map->camera().row_time != request.shutter->from) return false;
  const int key_frames = 2 + static_cast<int>(map->key_frame_count() / 25);  // after which the map is to have it
  background_.start(ShutterAdjustment::of(*map, request.shutter->to), key_frames);
  return true;
}

int Backend::keep_within_bound(KeyFrameId current) {
  const int most = options_.mapper.max_map_mb;
  if (most == 0) return 0;
  const LimitReport report = limit_map(map_, current, size_t{1'000'000} * static_cast<size_t>(most));
  const std::string bound = std::to_string(most) + " MB";
  if (report.erased > 0 && !std::exchange(told_.thins, true))
    log(LogLevel::warning,
        "the map has reached " + bound + ": from here on it loses key frames where that costs least");
  if (report.is_out_of_reach && !std::exchange(told_.out_of_reach, true))
    log(LogLevel::warning, "the map takes more than " + bound + ", and tracking needs all that is left of it");
  return report.erased;
}

std::vector<DepthAgainstMotion> Backend::check_depth(KeyFrameId current, MotionDepthCheck::Pace pace) {
  if (options_.sensor == Sensor::monocular) return {};
  auto [features, camera] = [&] {
    const auto map = map_.read();
    return std::pair(map->at(current).features, map->camera());
  }();
  camera.depth_noise = given_.depth_noise;  // what the map learned may have been learned from nonsense
  return depth_check_.add(features, camera, pace);
}

// Handles are held by the tracker (points of the last frame and counts, reported with the next key frame), by requests
// in the inbox, by the mapper's recent points, and by the claims of LoopConsensus: a few key frames.
void Backend::forget_replaced_points(KeyFrameId current) {
  constexpr uint32_t kKept = 100, kEvery = 20;  // key frames
  const uint32_t serial = map_.read()->at(current).serial;
  if (serial > kKept && serial % kEvery == 0) map_.write()->forget_forwarding(serial - kKept);
}

KeyFrameMoves Backend::finish() { return background_.running() ? finish_adjustment().moves : KeyFrameMoves(); }

void Backend::discard(uint32_t submap) {
  const auto map = map_.write();
  map->erase_submap(submap);
  if (!map->submaps().empty()) return;
  closer_.reset();
  refinement_.restart(*map);
}

}  // namespace covis
