// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/system.h"

#include <algorithm>

#include "covis/core/log.h"
#include "covis/core/time.h"

namespace covis {
namespace {

constexpr size_t kRecords = 1 << 14;  // of frames, room for which is made at once: memory is used only when they come

int index_of(const std::vector<SubmapSummary>& submaps, uint32_t submap) {
  for (size_t m = 0; m < submaps.size(); ++m) {
    if (submaps[m].id == submap) return static_cast<int>(m);
  }
  return -1;
}

}  // namespace

System::System(const Camera& camera, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
    : given_(camera),
      options_(options),
      vocabulary_(std::move(vocabulary)),
      map_(camera.pinhole),
      frontend_(camera, options.orb, options.sensor),
      tracker_(map_, options, vocabulary_),
      mapping_(map_, BackendOptions(options), vocabulary_) {
  records_.reserve(kRecords);
}

System::~System() = default;

FeaturesPtr System::extract(const Input& input, bool twice_the_features) {
  frontend_.set_feature_budget(options_.orb.features * (twice_the_features ? 2 : 1));
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

Result<void> System::set_map(Map map, const Camera& made_by) {
  if (const std::string other = difference(given_, made_by); !other.empty()) {
    const std::string what = "the map was made by another camera (" + other + ")";
    if (!options_.localize)
      return fail(what + ": it can't be gone on with, for a map has one camera; localise in it only");
    log(LogLevel::warning, what + ": places of it are looked for with the present one");
    own_camera_ = given_.pinhole;
    tracker_.use_camera(*own_camera_);
  }
  finish();
  if (vocabulary_) {
    for (const KeyFrameId& id : map.key_frames())
      map.set_words(id, std::make_shared<const Words>(vocabulary_->transform(map.at(id).features->descriptor)));
  }
  *map_.write() = std::move(map);
  tracker_.start_lost();
  return {};
}

std::optional<System::Location> System::locate(const Input& input) {
  mapping_.wait_idle();
  Tracker tracker(map_, options_, vocabulary_);
  if (own_camera_) tracker.use_camera(*own_camera_);
  const auto found = tracker.locate(extract(input, options_.tracker.local_map.weak_inliers > 0), input.frame);
  if (!found) return std::nullopt;
  return Location{found->T_cw.inverse(), found->submap};
}

FrameReport System::process(const Input& input) {
  FrameReport report;
  const Stopwatch total;
  FeaturesPtr features = extract(input, tracker_.wants_more_features());
  report.timing.extract_ms = frontend_.timing().extract_ms;
  report.timing.depth_ms = frontend_.timing().depth_ms;

  Stopwatch watch;
  ++processed_;
  if (options_.realtime) {
    collect(report, false);
  } else if (processed_ >= visible_at_ || tracker_.near_loss()) {
    collect(report, true);
  }
  report.timing.wait_ms = watch.ms();
  watch.restart();

  const bool live = options_.realtime || mapping_.pending() == 0;
  const bool idle = options_.realtime ? mapping_.idle() : mapping_.pending() == 0;
  Tracker::Outcome outcome = tracker_.track(std::move(features), input.frame, input.stamp, live, idle);
  report.track = outcome.result;
  report.timing.track_ms = watch.ms();

  if (outcome.retract_from) retract(*outcome.retract_from);
  FrameRecord& fresh = records_.emplace_back();
  fresh.frame = input.frame;
  fresh.stamp = input.stamp;
  if (outcome.discard_submap) {
    collect(report, true);
    discard(*outcome.discard_submap);
  }
  const bool first = outcome.result.method == TrackMethod::initialised;
  if (!first && outcome.result.state == TrackState::tracking) {
    FrameRecord& record = records_.back();
    record.tracked = record.online = true;
    record.pose = outcome.result.pose;
    record.T_wc_online = outcome.result.T_cw.inverse();
    record.submap_online = outcome.result.submap;
  }
  if (outcome.key_frame) {
    // Here, so that frames that make no key frame never allocate.
    if (2 * records_.size() > records_.capacity()) records_.reserve(2 * records_.capacity());
    mapping_.submit(std::move(*outcome.key_frame));
  }
  if (outcome.initial_map) mapping_.submit(std::move(*outcome.initial_map));
  if (first) {  // nothing can be tracked before the map is there
    watch.restart();
    collect(report, true);
    report.timing.wait_ms += watch.ms();
    report.track.state = tracker_.state();
    if (const FrameRecord& record = records_.back(); record.tracked) {
      report.track.T_cw = record.T_wc_online.inverse();
      report.track.pose = record.pose;
      report.track.submap = record.submap_online;
      report.track.inliers = report.mapping.back().counts.points_created;
    } else {
      report.track.method = TrackMethod::none;
      report.track.reason = "the initial map did not hold";
    }
  } else if (outcome.key_frame) {
    visible_at_ = processed_ + options_.mapping_delay;
  }
  report.timing.total_ms = total.ms();
  return report;
}

void System::collect(FrameReport& report, bool wait) {
  while (mapping_.pending() > 0) {
    std::optional<MappingReport> made = wait ? mapping_.wait() : mapping_.poll();
    if (!made) break;
    take(*made);
    report.mapping.push_back(std::move(*made));
  }
}

void System::take(const MappingReport& report) {
  tracker_.key_frame_made(report);
  if (!report.key_frame.valid()) return;
  // The frames that became key frames hang on themselves from now on.
  const auto map = map_.read();
  const auto hang = [&](KeyFrameId id, bool online) {
    const KeyFrame* key_frame = map->find(id);
    if (!key_frame) return;
    const auto record = std::lower_bound(records_.begin(), records_.end(), key_frame->frame,
                                         [](const FrameRecord& r, int64_t frame) { return r.frame < frame; });
    if (record == records_.end() || record->frame != key_frame->frame) return;
    if (!record->tracked && online) {
      record->online = true;
      record->T_wc_online = key_frame->T_cw.inverse();
      record->submap_online = key_frame->submap;
    }
    record->tracked = true;
    record->pose = RelativePose::at(*map, id);
  };
  hang(report.key_frame, true);
  if (report.first.valid()) hang(report.first, false);
}

void System::retract(int64_t from) {
  for (auto record = records_.rbegin(); record != records_.rend() && record->frame >= from; ++record)
    record->tracked = record->online = false;
}

void System::discard(uint32_t submap) {
  {
    const auto map = map_.read();
    for (FrameRecord& record : records_) {
      const auto resolved = record.pose.resolved(*map);
      if (resolved && map->at(resolved->key_frame).submap == submap) record.tracked = record.online = false;
    }
  }
  mapping_.discard(submap);
}

std::vector<MappingReport> System::finish() {
  FrameReport report;
  collect(report, true);
  if (tracker_.state() != TrackState::not_initialised) {
    mapping_.finish();
    tracker_.map_moved();
  }
  return std::move(report.mapping);
}

// Calls visit(record, T_wc, submap) for each frame that has a pose.
template <class Visit>
void System::for_each_pose(const Map& map, Visit&& visit) const {
  for (const FrameRecord& record : records_) {
    if (!record.tracked) continue;
    const auto resolved = record.pose.resolved(map);
    if (!resolved) continue;
    const SE3 T_cw = resolved->T_cw(map);
    visit(record, T_cw.inverse(), map.at(resolved->key_frame).submap);
  }
}

std::vector<SubmapSummary> System::submaps() const { return submaps(*map_.read()); }

std::vector<SubmapSummary> System::submaps(const Map& map) const {
  std::vector<SubmapSummary> submaps;
  for (const Submap& submap : map.submaps())
    submaps.push_back({submap.id, submap.id < tracker_.kept_submaps(), 0, submap.key_frames, 0});
  const auto of = [&](uint32_t submap) -> SubmapSummary& { return submaps[static_cast<size_t>(index_of(submaps, submap))]; };
  map.for_each_point([&](MapPointId, const MapPoint& point) { ++of(map.at(point.reference).submap).points; });
  for_each_pose(map, [&](const FrameRecord&, const SE3&, uint32_t submap) { ++of(submap).frames; });
  std::stable_sort(submaps.begin(), submaps.end(), [](const SubmapSummary& a, const SubmapSummary& b) {
    return a.loaded != b.loaded ? a.loaded : a.frames > b.frames;
  });
  return submaps;
}

std::vector<PoseOfFrame> System::trajectory() const {
  const auto map = map_.read();
  const std::vector<SubmapSummary> of = submaps(*map);
  std::vector<PoseOfFrame> poses;
  for_each_pose(*map, [&](const FrameRecord& record, const SE3& T_wc, uint32_t submap) {
    poses.push_back({record.frame, record.stamp, T_wc, index_of(of, submap), submap});
  });
  return poses;
}

std::vector<PoseOfFrame> System::online_trajectory() const {
  const std::vector<SubmapSummary> of = submaps();
  std::vector<PoseOfFrame> poses;
  for (const FrameRecord& record : records_) {
    if (record.online && index_of(of, record.submap_online) == 0)
      poses.push_back({record.frame, record.stamp, record.T_wc_online, 0, record.submap_online});
  }
  return poses;
}

std::vector<PoseOfFrame> System::key_frames() const {
  const auto map = map_.read();
  const std::vector<SubmapSummary> of = submaps(*map);
  std::vector<PoseOfFrame> poses;
  for (const KeyFrameId& id : map->key_frames()) {
    const KeyFrame& key_frame = map->at(id);
    const uint32_t submap = key_frame.submap;
    poses.push_back({key_frame.frame, key_frame.stamp, key_frame.T_cw.inverse(), index_of(of, submap), submap});
  }
  return poses;
}

}  // namespace covis
