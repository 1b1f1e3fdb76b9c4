// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/tracker.h"

#include <string>
#include <utility>

#include "covis/core/log.h"
#include "covis/core/time.h"

namespace covis {
namespace {

MapStarter::Settings starter_settings(const TrackingSettings& s, const Vocabulary* vocabulary) {
  // Without places recognised, or loops closed, two submaps would never be joined.
  return {s.sensor, s.options.start, s.options.key_frame.min_close_points, vocabulary && s.closes_loops, s.seed};
}

FirstPose::Support support_of(const TrackingSettings& s) {
  return s.dead_reckons() ? FirstPose::Support::all_points : FirstPose::Support::map_points;
}

}  // namespace

Tracker::Tracker(const SharedMap& map, const TrackingSettings& settings, std::shared_ptr<const Vocabulary> vocabulary)
    : map_(map),
      settings_(settings),
      search_(settings.options.recovery, Subject::stream, settings.shutter),
      first_pose_(settings.sensor, settings.options.first_pose, support_of(settings), settings.seed),
      key_frames_(settings.sensor, settings.options.key_frame, settings.schedule),
      starter_(starter_settings(settings, vocabulary.get())),
      relocaliser_(map, settings.options, settings.seed, std::move(vocabulary)) {
  search_.image = settings.image;
  search_.refresh_camera(*map_.read());
}

// ---- One frame ----

Tracker::Outcome Tracker::track(FeaturesPtr features, int64_t frame, Timestamp stamp, const MappingStatus& mapping) {
  const SharedMap* live = mapping.map == MappingStatus::Map::live ? &map_ : nullptr;
  const bool realtime = settings_.schedule == Schedule::realtime;
  const auto moves = [&] { return realtime ? std::optional(last_.moves) : std::nullopt; };
  if (mapping.depth == MappingStatus::Depth::right) depth_.trust_depth();
  features = search_.shutter.straighten(std::move(features), search_.camera, stamp);
  current_.start(depth_.receive(std::move(features)), frame, stamp);
  health_.leaves_map = state_ == TrackingState::tracking && settings_.mode == TrackingMode::mapping &&
                       starter_.may_begin_beside() && depth_.blames_map(stamp);
  Outcome outcome;
  TrackResult& result = outcome.result;
  result.features = current_.features->size();
  if (state_ == TrackingState::not_initialised) {
    search_.refresh_camera(*map_.read());
    begin_submap(outcome);
  } else {
    if (live && (last_.map_changed || realtime)) {
      follow_map(*map_.read());
      last_.map_changed = false;
    }
    FeaturesPtr received = current_.features;
    const int dead_reckoned = health_.dead_reckoned_frames;
    bool found = find_pose(result, live);
    // In real time a loop may have been closed meanwhile: what was read before does not fit what was read after.
    for (int again = 0; found && realtime && map_.read()->moves() != last_.moves; ++again) {
      current_.features = received;
      health_.dead_reckoned_frames = dead_reckoned;
      follow_map(*map_.read());
      received = current_.features;
      found = again < 2 && find_pose(result, live);
    }
    if (!found) lose(outcome, live);
    outcome.retract_from = search_.place.take_retraction();
    if (outcome.retract_from) backlog_.lost();
    if (found) {
      if (search_.local_map.reference.submap != last_.submap && result.method != TrackMethod::initialised)
        depth_.change_map(current_);
      if (result.method != TrackMethod::initialised) {
        const Stopwatch watch;
        if (state_ == TrackingState::tracking && search_.local_map.reference.submap == last_.submap &&
            search_.place.tentative_since() != current_.stamp && !result.doubts.torn)
          search_.shutter.follow({last_.frame.T_cw, last_.frame.stamp}, search_.camera, current_);
        search_.alignment.refine_pose(live, search_.camera, moves(), current_);
        result.ms.align = watch.ms();
      }
      result.doubts.depth_contradiction = depth_.judge(current_, search_.camera, live);
      if (health_.leaves_map && depth_.blames_map(stamp) && !result.doubts.torn) begin_submap(outcome);
    }
    if (found && result.method != TrackMethod::initialised) {
      accept(result);
      if (!result.tentative) search_.moving.find(current_, search_.local_map, search_.camera);
      if (search_.place.tentative() || starter_.may_give_up(live, last_.pose.key_frame)) {
        backlog_.keep_for_now(current_);
      } else {
        backlog_.settle();
      }
      const bool sure = !search_.place.tentative() && !result.doubts.torn &&
                        (!health_.recovered_lately(current_.stamp) || result.method == TrackMethod::motion_model);
      if (sure && settings_.mode == TrackingMode::mapping &&
          key_frames_.is_due(current_, result.inliers, search_.local_map, search_.camera, mapping.load)) {
        KeyFrameRequest request = key_frames_.request(current_, last_.pose, search_.camera);
        request.turn_rate = search_.shutter.turn_rate();
        request.shutter = search_.shutter.found(search_.camera);
        request.unlocated = backlog_.take();
        outcome.request = std::move(request);
        result.key_frame = true;
        if (live && !realtime) search_.alignment.keep_views(*live->read(), search_.local_map.points);
      }
    }
  }
  if (live && state_ == TrackingState::tracking && result.method == TrackMethod::motion_model && !result.tentative) {
    const auto map = live->read();
    if (!moves() || map->moves() == *moves())
      result.shutter = search_.shutter.compare(current_, search_.camera, *map, last_.pose.key_frame);
  }
  if (state_ != TrackingState::tracking || result.method == TrackMethod::initialised) backlog_.keep(current_);
  result.state = state_;
  result.moves = last_.moves;
  constexpr int kNearLoss = 2;  // times the inliers that a pose needs
  health_.near_loss = result.inliers < kNearLoss * settings_.options.local_map.min_inliers;
  std::swap(last_.frame, current_);
  depth_.release();  // the ring of features wants them back
  return outcome;
}

bool Tracker::find_pose(TrackResult& result, const SharedMap* live) {
  constexpr int kRelocaliseEvery = 5;  // dead-reckoned frames: dead reckoning drifts
  // Dead reckoning drifts: the camera is to be found in the map before it is mapped from there.
  const bool carried = settings_.mode == TrackingMode::mapping && health_.dead_reckoned_frames > 0;
  if (state_ == TrackingState::tracking && !carried) {
    const bool has_others = health_.leaves_map && live && live->read()->submaps().size() > 1;
    if (has_others && relocalise(result, live, last_.submap)) return true;
    const int reckoned = health_.dead_reckoned_frames;
    if (reckoned > 0 && reckoned % kRelocaliseEvery == 0 && relocalise(result, live)) return true;
    if (find_first_pose(result) && (track_local_map(result, live) || dead_reckon(result))) return true;
  }
  return relocalise(result, live);
}

bool Tracker::find_first_pose(TrackResult& result) {
  const Stopwatch watch;
  // The depth of torn rows would carry the pose away from the map.
  if (settings_.sensor != Sensor::monocular && !search_.torn.was_torn(last_.frame.stamp))
    last_.add_depth_points(key_frames_.near_features(*last_.frame.features, search_.camera), search_.camera);
  const std::optional<SE3> T_cl = motion_.predict(current_.stamp - last_.frame.stamp);
  const bool ok = first_pose_.find(last_.frame, T_cl, current_, search_, result);
  result.ms.motion += watch.ms();
  return ok;
}

bool Tracker::track_local_map(TrackResult& result, const SharedMap* live) {
  constexpr double kFactorRecovered = 5;  // factor on the windows: the pose of a camera just found again is less sure
  const LocalMapOptions& o = settings_.options.local_map;
  const Stopwatch watch;
  if (live) search_.update_local_map(*live, current_, last_.pose.key_frame, o.local_key_frames);
  result.ms.local_update += watch.ms();
  const bool recovered_lately = health_.recovered_lately(current_.stamp);
  const double factor = recovered_lately ? kFactorRecovered : o.window_factor(settings_.sensor);
  search_.unfitted.keep(current_);
  search_.fit_local_map(o, factor, current_, result);
  if (result.method == TrackMethod::motion_model && belief_.is_short(result))
    search_.fit_local_map_from(*motion_.predict(current_.stamp - last_.frame.stamp) * last_.frame.T_cw, o, factor,
                               belief_, current_, result);
  if (result.inliers < (recovered_lately ? settings_.options.recovery.min_inliers_recovered : o.min_inliers)) {
    result.reason = NoPoseReason::few_map_points_agree;
    return false;
  }
  const SE3 T_cl = current_.T_cw * last_.frame.T_cw.inverse();
  if (!belief_.explains_view(result, first_pose_.images_agree(T_cl))) {
    result.reason = NoPoseReason::little_of_view_explained;
    return false;
  }
  const bool is_short = belief_.is_short(result);
  if (!is_short) search_.torn.whole();
  result.doubts.torn =
      is_short && (search_.torn.judge(search_.local_map, search_.view.points(), current_, search_.camera) ||
                   (belief_.is_weak(result) && search_.torn.judge_after_torn(current_.stamp)));
  const bool tentative = search_.place.tentative();
  if (tentative && !well_determined(current_.information, current_.mean_depth(), search_.camera)) {
    result.reason = NoPoseReason::pose_uncertain;
    return false;
  }
  const bool by_descriptors = result.method == TrackMethod::last_frame;
  const bool may_be_elsewhere =
      tentative || recovered_lately || by_descriptors || result.method == TrackMethod::reference_key_frame;
  const Arrival arrival = by_descriptors ? Arrival::recognised : Arrival::tracked;
  if (may_be_elsewhere && !search_.place.is_right(search_.found(current_, live), arrival)) {
    result.reason = NoPoseReason::place_looks_different;
    return false;
  }
  return true;
}

// In localisation only: the last frame's depth carries the pose over a place with too few map points. Where there were
// enough of them their pose was refused, and is not to come back this way.
bool Tracker::dead_reckon(TrackResult& result) {
  const int least = settings_.options.local_map.min_inliers;
  if (!settings_.dead_reckons() || result.inliers >= least || current_.matches() < least) return false;
  ++health_.dead_reckoned_frames;
  result.method = TrackMethod::dead_reckoned;
  return true;
}

// `but`: a submap that its depth blames, so that the camera is looked for in the others, by its depth as well.
bool Tracker::relocalise(TrackResult& result, const SharedMap* live, std::optional<uint32_t> but) {
  const Stopwatch watch;
  result.doubts.torn = false;  // it was judged at a pose that was refused
  FeaturesPtr tracked_by = current_.features;
  if (but) current_.features = depth_.measured();
  const bool found = relocaliser_.find(current_, search_, live, {last_.pose.key_frame, but}, result);
  if (!found) current_.features = std::move(tracked_by);
  result.ms.motion += watch.ms();
  if (found) {
    health_.last_recovery = current_.stamp;
    result.method = TrackMethod::recovered;
    result.first_share = 0;  // that of a hypothesis which was refused
    // A look-alike shows only what matched, not all that stands around it.
    if (belief_.is_weak(result) && !search_.place.is_shown(search_.found(current_, live)))
      search_.place.doubt(current_);
  } else if (state_ == TrackingState::lost || result.reason == NoPoseReason::none) {
    result.reason = NoPoseReason::no_key_frame_matches;
  }
  return found;
}

void Tracker::accept(TrackResult& result) {
  const KeyFrameView& reference = search_.local_map.reference;
  if (!result.doubts.torn && !search_.place.tentative())
    key_frames_.count(current_, search_.local_map, search_.matcher.in_view());
  const Timestamp elapsed = current_.stamp - last_.frame.stamp;
  if (state_ != TrackingState::tracking || elapsed <= 0 || reference.submap != last_.submap) {
    motion_.reset();
  } else if (search_.place.tentative_since() != current_.stamp) {
    // A step from a wrong place to the right one is no motion; the motion before goes on.
    motion_.observe((current_.T_cw * last_.frame.T_cw.inverse()).normalized(), elapsed);
  }
  state_ = TrackingState::tracking;
  if (result.method != TrackMethod::dead_reckoned && !result.doubts.torn) belief_.accept(result);
  search_.place.accept(current_, reference.submap);
  const bool tentative = search_.place.tentative();
  starter_.accept(tentative ? MapStarter::Place::tentative : MapStarter::Place::settled);
  if (result.method != TrackMethod::dead_reckoned) health_.dead_reckoned_frames = 0;
  // Twice the features give more inliers by themselves; leaving the weak state asks for more than that.
  const int weak = settings_.options.local_map.weak_inliers;
  health_.weak = health_.weak ? 2 * result.inliers < 5 * weak : result.inliers < weak;
  last_.pose = {reference.id, reference.scale, current_.T_cw * reference.T_cw.inverse()};
  last_.submap = reference.submap;
  backlog_.found_at(reference.id);
  result.doubts.map_on_probation = depth_.is_on_probation(current_.stamp);
  result.tentative = tentative || result.doubts.any();
  result.T_cw = current_.T_cw;
  result.information = current_.information;
  result.pose = last_.pose;
  result.submap = last_.submap;
  result.reason = NoPoseReason::none;
}

void Tracker::lose(Outcome& outcome, const SharedMap* live) {
  if (state_ != TrackingState::lost)
    log(LogLevel::warning, std::string("tracking lost: ").append(describe(outcome.result.reason)));
  state_ = TrackingState::lost;
  health_.weak = settings_.options.local_map.weak_inliers > 0;
  health_.dead_reckoned_frames = 0;
  outcome.result.doubts.map_on_probation = depth_.is_on_probation(current_.stamp);
  // A map on probation proves wrong, or the place since a jump, and in a pause nothing was seen.
  if (const auto begun = depth_.probation_since(current_.stamp)) starter_.note_loss(*begun);
  if (const auto jumped = search_.place.tentative_since()) starter_.note_loss(*jumped);
  if (motion_.is_pause(current_.stamp - last_.frame.stamp)) starter_.note_loss(last_.frame.stamp);
  motion_.reset();
  search_.place.lose();
  backlog_.lost();
  // In localisation only no submap is begun or given up.
  if (settings_.mode == TrackingMode::localisation) return;
  if (search_.torn.may_go_on(current_.stamp)) return starter_.note_loss(current_.stamp);
  const MapStarter::Loss loss = starter_.lose(current_.stamp, last_.pose.key_frame, live);
  using Step = MapStarter::Step;
  if (loss.step == Step::begin_submap || loss.step == Step::replace_submap) begin_submap(outcome);
  const bool replaced = loss.step == Step::replace_submap && state_ == TrackingState::tracking;
  if (loss.step != Step::give_up_submap && !replaced) return;
  log(LogLevel::warning, "the initial map was lost at once and is given up; initialising again");
  outcome.discard_submap = loss.submap;
  if (!replaced && !starter_.is_beginning()) state_ = TrackingState::not_initialised;
  search_.local_map.clear();
  key_frames_.clear_counts();
}

// Asks for a submap that begins with this frame, if it is good for one; key_frame_made() says whether it holds.
void Tracker::begin_submap(Outcome& outcome) {
  TrackResult& result = outcome.result;
  FeaturesPtr tracked_by = std::exchange(current_.features, depth_.measured());
  MapStarter::Offer offer = starter_.offer(current_, search_.camera);
  if (settings_.sensor == Sensor::monocular) result.predicted_matches = offer.matches;
  if (std::holds_alternative<std::monostate>(offer.request)) {
    // A lost camera keeps the reason of its loss.
    if (result.reason == NoPoseReason::none) result.reason = offer.reason;
    current_.features = std::move(tracked_by);
    return;
  }
  motion_.reset();
  if (result.doubts.depth_contradiction > 0)
    log(LogLevel::warning, "depth contradicts the map for long: a new map is begun beside the old one");
  result.reason = NoPoseReason::none;
  outcome.request = std::move(offer.request);
  state_ = TrackingState::tracking;
  depth_.begin(current_.stamp);
  result.doubts = {.map_on_probation = depth_.is_on_probation(current_.stamp)};
  result.tentative = result.doubts.any();
  key_frames_.begin(current_.stamp);
  if (settings_.sensor != Sensor::monocular) current_.T_cw = SE3();
  current_.clear_matches();  // they are matches with an older submap
  result.inliers = 0;
  result.method = TrackMethod::initialised;
  result.key_frame = true;
}

// ---- The map as it changes ----

void Tracker::key_frame_made(const KeyFrameMade& made) {
  last_.map_changed = true;
  const bool begun = starter_.begun_with(made.frame);  // reports of older key frames may come before it
  if (!made.key_frame.valid()) {
    if (begun) state_ = starter_.is_beginning() ? TrackingState::lost : TrackingState::not_initialised;
    return;
  }
  const auto map = map_.read();
  if (begun) {
    starter_.begun();
    backlog_.found_at(made.key_frame);
    last_.become(*map, made.key_frame);
    search_.place.restart_at(last_.frame, last_.submap);
    last_.map_changed = search_.camera != map->camera();  // else the frame is as new as the submap
  }
  last_.new_reference = made.key_frame;
  if (last_.frame.index == made.frame) last_.take_points(*map, made.key_frame);
  LocalMap& local_map = search_.local_map;
  if (local_map.reference.id != last_.pose.key_frame || local_map.size() == 0)
    local_map.update(*map, {}, made.key_frame, settings_.options.local_map.local_key_frames);
}

void Tracker::follow_map(const Map& map) {
  if (last_.moves != map.moves()) search_.place.forget_settled();
  last_.moves = map.moves();
  search_.refresh_camera(map);
  last_.frame.straighten_for(search_.camera);
  depth_.straighten_for(search_.camera, current_);
  if (const auto resolved = last_.pose.resolved(map)) {
    const double growth = last_.pose.growth(map);
    motion_.rescale(growth);
    last_.pose = *resolved;
    last_.submap = map.at(resolved->key_frame).submap;
    last_.frame.T_cw = last_.pose.T_cw(map).normalized();
    search_.place.follow(last_.frame.T_cw, last_.submap, growth);
  }
  // A new key frame becomes the reference unless the camera was meanwhile found in another submap.
  if (const KeyFrame* made = map.find(last_.new_reference); made && made->submap == last_.submap)
    last_.pose = RelativePose::of(map, last_.frame.T_cw, last_.new_reference);
  last_.new_reference = {};
  last_.refresh_points(map);
  if (map.find(last_.pose.key_frame)) search_.local_map.reference.copy(map, last_.pose.key_frame);
}

void Tracker::start_lost() {
  state_ = TrackingState::lost;
  health_.weak = settings_.options.local_map.weak_inliers > 0;
  motion_.reset();
  const auto map = map_.read();
  search_.refresh_camera(*map);
  search_.place.restart();
  search_.local_map.clear();
  starter_.keep_submaps(*map);
  last_ = {};
  key_frames_.clear_counts();
}

void Tracker::set_mode(TrackingMode mode) {
  if (mode == settings_.mode) return;
  settings_.mode = mode;
  first_pose_.set_support(support_of(settings_));
  if (mode == TrackingMode::localisation) {
    if (state_ == TrackingState::not_initialised) start_lost();
  } else if (map_.read()->submaps().empty()) {
    state_ = TrackingState::not_initialised;
  }
}

bool Tracker::wants_more_features() const {
  const bool monocular = settings_.sensor == Sensor::monocular;
  if (state_ == TrackingState::not_initialised) return monocular;
  // A tentative place was found with twice the features, and is held against what that showed.
  const bool holds_place = settings_.options.local_map.weak_inliers > 0 && search_.place.tentative();
  return health_.weak || holds_place || (starter_.is_beginning() && monocular);
}

}  // namespace covis
