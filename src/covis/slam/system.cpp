// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/system.h"

#include <algorithm>
#include <string>
#include <utility>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/features/extractor.h"
#include "covis/map/camera_change.h"
#include "covis/map/map_state.h"
#include "covis/slam/map_camera.h"
#include "covis/tracking/backtrack.h"

namespace covis {
namespace {

bool finds_shutter(const SystemOptions& options, const Camera& camera) {
  return options.tracker.readout == kFindReadout && camera.pinhole.row_time == 0;
}

// The readout in the settings goes before that of the camera.
Camera with_shutter(Camera camera, const SystemOptions& options) {
  const double readout = options.tracker.readout;
  if (readout != kFindReadout) camera.pinhole.row_time = readout / camera.height;
  return camera;
}

ShutterOptions shutter_of(const Camera& camera, const SystemOptions& options) {
  using RowTime = ShutterOptions::RowTime;
  return {camera.height, finds_shutter(options, camera) ? RowTime::sought : RowTime::given};
}

// A first frame is not asked for more features than there can be.
TrackingSettings tracking_settings(SystemOptions o, const Camera& camera, const ImageProbe& image) {
  o.tracker.start.init_features =
      std::min({o.tracker.start.init_features, o.orb.features / 2, keypoint_room(o.orb, camera.width, camera.height)});
  return {.sensor = o.sensor,
          .options = o.tracker,
          .schedule = o.schedule(),
          .mode = o.localize ? TrackingMode::localisation : TrackingMode::mapping,
          .closes_loops = o.loop.close,
          .seed = o.seed,
          .shutter = shutter_of(camera, o),
          .image = &image};
}

// Noise, distortion and registration that were given are not looked for.
BackendOptions backend_options(const SystemOptions& options, const Camera& camera) {
  BackendOptions made(options);
  made.mapper.estimate_depth_noise &= options.sensor == Sensor::rgbd && !camera.pinhole.depth_noise.known();
  made.mapper.register_depth &= options.sensor == Sensor::rgbd && !camera.pinhole.registration.any();
  made.mapper.refine_distortion &= options.sensor != Sensor::rgbd && camera.distortion == Distortion::none;
  return made;
}

}  // namespace

System::System(const Camera& camera, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
    : given_(with_shutter(camera, options)),
      options_(options),
      vocabulary_(std::move(vocabulary)),
      map_(for_sensor(given_.pinhole, options.sensor)),
      log_(static_cast<size_t>(options.trajectory_frames)),
      frontend_(given_, options.orb, options.sensor),
      tracker_(map_, tracking_settings(options, given_, frontend_.probe()), vocabulary_),
      mapping_(map_, backend_options(options, given_), vocabulary_) {
  // A lost camera is looked for in the map; it begins none.
  if (options_.localize) tracker_.start_lost();
}

System::~System() = default;

Result<void> System::set_map(Map map, const Camera& made_by) {
  // Handles of the map that is there would name other things in this one.
  if (frames_.processed > 0) return fail("a map can be put in place before the first frame only");
  if (!options_.localize) {
    if (auto continued = check_continued(map, options_.sensor); !continued) return continued;
  }
  Pinhole camera = camera_for(map, made_by, given_, options_.sensor);
  if (!finds_shutter(options_, given_)) camera.row_time = given_.pinhole.row_time;
  const std::string other = difference(given_, made_by);
  if (!other.empty())
    log(LogLevel::info, "the map was made by another camera (" + other + "); it is expressed in the present one");
  if (!other.empty() || !same_corrections(camera, map.camera())) {
    MapState state = map.state();
    map = Map();  // so that features are not held twice
    if (auto fits = express_in(state, made_by, {given_, camera}); !fits) return fits;
    auto expressed = Map::from_state(std::move(state));
    if (!expressed) return tl::unexpected(expressed.error());
    map = std::move(*expressed);
  }
  map.set_camera(camera);
  finish();
  if (vocabulary_) {
    for (const KeyFrameId& id : map.key_frames())
      map.set_words(id, std::make_shared<const Words>(vocabulary_->transform(map.at(id).features->descriptor)));
  }
  snapshots_.map_loaded(map.next_submap());
  colours_.map_loaded(map.next_serial());
  *map_.write() = std::move(map);
  tracker_.start_lost();
  return {};
}

FrameReport System::process(const Input& input) {
  FrameReport report;
  const Stopwatch total;
  const bool more_features = tracker_.wants_more_features();
  FeaturesPtr features = extract(input, (more_features ? 2 : 1) * options_.orb.features);
  report.timing.extract_ms = frontend_.timing().extract_ms;
  report.timing.depth_ms = frontend_.timing().depth_ms;

  using Budget = SensorMonitor::Budget;
  monitor_.add_frame(input.frame, *features, frontend_.row_error(), more_features ? Budget::doubled : Budget::usual);
  const MappingStatus::Depth depth = compare_depth(input, features, report);
  if (options_.sensor == Sensor::rgbd && !input.depth.empty())
    monitor_.add_images(input.frame, input.image, input.depth, frontend_.registration());
  ++frames_.processed;
  apply_visible_mapping(report);
  mapping_.rethrow_failure();

  const Stopwatch tracking;
  Tracker::Outcome outcome = tracker_.track(std::move(features), input.frame, input.stamp, mapping_status(depth));
  report.track = outcome.result;
  report.timing.track_ms = tracking.ms();

  record(input, outcome, report);
  if (outcome.discard_submap) {
    apply_all_mapping(report);
    discard(*outcome.discard_submap);
    report.discarded_submap = outcome.discard_submap;
  }
  if (auto* const key_frame = std::get_if<KeyFrameRequest>(&outcome.request))
    key_frame->depth = kept_depth(input, *key_frame->features);
  submit(std::move(outcome.request));
  if (outcome.result.method == TrackMethod::initialised) {  // the map has to be there before a frame can be tracked
    apply_all_mapping(report);
    report_begun_map(report);
  }
  explain_missing_map(report.track);
  watch_sensor(input.frame, report);
  report.timing.total_ms = total.ms();
  return report;
}

std::optional<LocatedImage> System::locate(const Input& input) {
  mapping_.wait_idle();
  Relocaliser relocaliser(map_, options_.tracker, options_.seed, vocabulary_);
  const int budget = (options_.tracker.local_map.weak_inliers > 0 ? 2 : 1) * options_.orb.features;
  const auto found = relocaliser.locate(extract(input, budget), input.frame, &frontend_.probe());
  if (!found) return std::nullopt;
  return LocatedImage{{found->T_cw.inverse(), found->submap}, found->inliers, found->information};
}

std::vector<MappingReport> System::finish() {
  FrameReport report;
  apply_all_mapping(report);
  if (tracker_.state() != TrackingState::not_initialised) {
    const KeyFrameMoves moves = mapping_.finish();  // before the map is read, as it waits for a writer
    log_.follow(*map_.read(), moves);
    tracker_.map_moved();
    take(backtrack(map_, {options_.sensor, options_.tracker, options_.seed}, tracker_.take_unlocated()));
    if (!frames_.late.empty()) {
      Relocaliser relocaliser(map_, options_.tracker, options_.seed, vocabulary_);
      for (const LocatedFrame& located : frames_.late.locate(std::move(relocaliser), trajectory()))
        log_.locate(located);
    }
  }
  return std::move(report.mapping);
}

void System::take(Backtracked earlier) {
  for (const LocatedFrame& located : earlier.located) log_.locate(located);
  frames_.late.keep(std::move(earlier.left));
}

Result<std::vector<MappingReport>> System::set_mode(TrackingMode mode) {
  if (mode == TrackingMode::mapping && options_.localize) {
    if (auto continued = check_continued(*map_.read(), options_.sensor); !continued)
      return tl::unexpected(continued.error());
  }
  std::vector<MappingReport> reports = finish();
  options_.localize = mode == TrackingMode::localisation;
  tracker_.set_mode(mode);
  return reports;
}

std::vector<SensorWarning> System::take_warnings() {
  std::vector<SensorWarning> warnings = monitor_.take_warnings();
  for (const SensorWarning& warning : warnings)
    log(LogLevel::warning, "frame " + std::to_string(warning.frame) + ": " + describe(warning, options_.sensor));
  return warnings;
}

std::vector<TrackedPoint> System::tracked_points() const {
  std::vector<TrackedPoint> points;
  if (tracker_.state() != TrackingState::tracking) return points;
  const TrackedFrame& frame = tracker_.last_frame();
  const auto &u = frame.features->image_x(), &v = frame.features->image_y();
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (!frame.on_map(i)) continue;
    const Eigen::Vector3d& p = frame.positions[i];
    points.push_back({u[i], v[i], id_number(frame.points[i]), p.x(), p.y(), p.z()});
  }
  return points;
}

std::vector<ViewedKeypoint> System::viewed_keypoints() const {
  std::vector<ViewedKeypoint> seen;
  const TrackedFrame& frame = tracker_.last_frame();
  if (!frame.features) return seen;
  const bool tracking = tracker_.state() == TrackingState::tracking;
  const auto &u = frame.features->image_x(), &v = frame.features->image_y();
  MatchedPoints matched;
  matched.mark(frame);
  for (size_t i = 0; i < u.size(); ++i) {
    const bool on_map = tracking && frame.on_map(i);
    seen.push_back({u[i], v[i], on_map ? ViewedKeypoint::Kind::tracked : ViewedKeypoint::Kind::unmatched});
  }
  if (!tracking) return seen;
  const PointSet& points = tracker_.search().local_map.points;
  const std::vector<uint8_t>& expected = tracker_.search().view.points();
  for (size_t k = 0; k < std::min(points.size(), expected.size()); ++k) {
    if (!expected[k] || matched.contains(points.id[k])) continue;
    const auto pixel = image_pixel(given_, tracker_.search().camera, frame.T_cw * points.position(k));
    if (!pixel) continue;
    seen.push_back({static_cast<float>(pixel->x()), static_cast<float>(pixel->y()), ViewedKeypoint::Kind::lost});
  }
  return seen;
}

std::vector<PoseOfFrame> System::online_trajectory() const {
  const auto now = snapshot();
  return now->submaps.empty() ? std::vector<PoseOfFrame>() : poses_in(now->online, now->submaps.front().id);
}

System::MapSize System::map_size() const {
  const auto map = map_.read();
  return {map->key_frame_count(), map->point_count()};
}

MapState System::map_state() const { return map_.read()->state(); }

// `features`: the number of keypoints wanted.
FeaturesPtr System::extract(const Input& input, int features) {
  frontend_.set_feature_budget(features);
  frontend_.follow(tracker_.search().camera);
  switch (options_.sensor) {
    case Sensor::monocular:
      return frontend_.monocular(input.image);
    case Sensor::stereo:
      return frontend_.stereo(input.image, input.right);
    case Sensor::rgbd:
      return frontend_.rgbd(input.image, input.depth);
  }
  return nullptr;
}

// For a key frame of these features; null where their depths need not be looked up again.
std::shared_ptr<const KeptDepth> System::kept_depth(const Input& input, const Features& features) const {
  const bool may_be_asked = options_.sensor == Sensor::rgbd && options_.mapper.register_depth &&
                            features.has_any_depth() && !frontend_.registration().any() &&
                            RegistrationSchedule::keeps_depths(*map_.read());
  return may_be_asked ? std::make_shared<const KeptDepth>(input.depth) : nullptr;
}

void System::apply_visible_mapping(FrameReport& report) {
  if (realtime()) {
    apply_finished_mapping(report);
  } else if (frames_.processed >= frames_.visible_at || tracker_.near_loss()) {
    apply_all_mapping(report);
  }
}

// Waits for every key frame asked for.
void System::apply_all_mapping(FrameReport& report) {
  const Stopwatch watch;
  while (mapping_.pending() > 0) apply(mapping_.wait(), report);
  mapping_.rethrow_failure();
  report.timing.wait_ms += watch.ms();
}

void System::apply_finished_mapping(FrameReport& report) {
  while (mapping_.pending() > 0) {
    std::optional<MappingReport> made = mapping_.poll();
    if (!made) return;
    apply(std::move(*made), report);
  }
}

void System::apply(MappingReport made, FrameReport& report) {
  tracker_.key_frame_made(made);
  for (const DepthAgainstMotion& check : made.depth_checks) monitor_.add_comparison(made.frame, check);
  if (made.key_frame.valid()) anchor(made);
  if (!made.moves.of.empty()) log_.follow(*map_.read(), std::exchange(made.moves, {}));
  take(std::move(made.earlier));
  report.mapping.push_back(std::move(made));
}

void System::anchor(const KeyFrameMade& made) {
  std::optional<uint64_t> forgettable;
  {
    const auto map = map_.read();
    anchor_in(*map, made);
    forgettable = log_.reanchor(*map);
  }
  if (forgettable) mapping_.forget_erased(*forgettable);
}

void System::anchor_in(const Map& map, const KeyFrameMade& made) {
  if (const KeyFrame* key_frame = map.find(made.key_frame)) {
    log_.anchor(key_frame->frame, RelativePose::at(map, made.key_frame),
                SubmapPose{key_frame->T_cw.inverse(), key_frame->submap});
  }
  if (const KeyFrame* first = map.find(made.first)) log_.anchor(first->frame, RelativePose::at(map, made.first));
}

MappingStatus System::mapping_status(MappingStatus::Depth depth) const {
  const bool nothing_pending = mapping_.pending() == 0;
  const bool idle = realtime() ? mapping_.idle() : nothing_pending;
  return {realtime() || nothing_pending ? MappingStatus::Map::live : MappingStatus::Map::hidden,
          idle ? MappingLoad::idle : MappingLoad::busy, depth};
}

void System::submit(MapRequest request) {
  if (auto* const key_frame = std::get_if<KeyFrameRequest>(&request)) {
    key_frame->doubted_depth = monitor_.doubts_depth();
    key_frame->suspected_depth = monitor_.suspects_depth();
    log_.make_room();  // here, so that frames that make no key frame never allocate
    frames_.visible_at = frames_.processed + options_.mapping_delay;
    mapping_.submit(std::move(*key_frame));
  } else if (auto* const initial_map = std::get_if<InitialMapRequest>(&request)) {
    mapping_.submit(std::move(*initial_map));
  }
}

// The frame that begins a submap gets its pose when mapping has made the submap.
void System::record(const Input& input, const Tracker::Outcome& outcome, FrameReport& report) {
  if (outcome.retract_from) report.retracted_from = log_.retract(*outcome.retract_from);
  const TrackResult& result = outcome.result;
  FrameRecord record{.frame = input.frame, .stamp = input.stamp, .pose = {}, .online = {}};
  if (result.state == TrackingState::tracking && result.method != TrackMethod::initialised) {
    record.pose = result.pose;
    record.shutter = result.shutter;
    record.moves = result.moves;
    record.online = SubmapPose{result.T_cw.inverse(), result.submap};
  }
  log_.append(record);
}

void System::discard(uint32_t submap) {
  log_.forget(*map_.read(), submap);
  mapping_.discard(submap);
}

MappingStatus::Depth System::compare_depth(const Input& input, const FeaturesPtr& features, FrameReport& report) {
  const Stopwatch watch;
  Pinhole camera = tracker_.search().camera;
  // What the map learned of it may have been learned from nonsense.
  camera.depth_noise = for_sensor(given_.pinhole, options_.sensor).depth_noise;
  const bool is_right = monitor_.add_view(input.frame, input.stamp, features, camera);
  report.timing.depth_ms += watch.ms();
  return is_right ? MappingStatus::Depth::right : MappingStatus::Depth::unknown;
}

// Poses that follow from depth which is not to be believed are tentative at best.
void System::watch_sensor(int64_t frame, FrameReport& report) {
  using Rows = SensorMonitor::Rows;
  using MapTrust = SensorMonitor::MapTrust;
  const FrameDoubts& doubts = report.track.doubts;
  monitor_.add_map_comparison(frame, doubts.depth_contradiction);
  monitor_.add_map_trust(doubts.map_on_probation ? MapTrust::on_probation : MapTrust::usual);
  monitor_.add_rows(frame, doubts.torn ? Rows::displaced : Rows::in_place);
  report.warnings = take_warnings();
  if (report.track.state == TrackingState::tracking) report.track.tentative |= monitor_.doubts();
}

void System::report_begun_map(FrameReport& report) const {
  TrackResult& track = report.track;
  track.state = tracker_.state();
  const std::optional<FrameRecord> record = log_.last();
  if (record->pose) {
    track.T_cw = record->online->T_wc.inverse();
    track.pose = *record->pose;
    track.submap = record->online->submap;
    track.inliers = report.mapping.back().counts.points_created;
  } else {
    track.method = TrackMethod::none;
    track.reason = NoPoseReason::initial_map_failed;
  }
}

void System::explain_missing_map(TrackResult& result) const {
  if (options_.localize && result.state != TrackingState::tracking && map_.read()->submaps().empty())
    result.reason = NoPoseReason::no_map_to_localise_in;
}

}  // namespace covis
