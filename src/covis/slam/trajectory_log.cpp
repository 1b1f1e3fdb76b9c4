// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/trajectory_log.h"

#include <algorithm>
#include <utility>

#include "covis/slam/frames_between.h"

namespace covis {
namespace {

void take_back(FrameRecord& record) {
  record.pose.reset();
  record.online.reset();
  record.shutter = {};  // it corrects that pose
}

}  // namespace

void TrajectoryLog::append(const FrameRecord& record) {
  const std::lock_guard lock(mutex_);
  ++revision_;
  if (most_ > 0 && records_.size() == 2 * most_) records_.erase_front(most_);
  records_.push_back(record);
}

void TrajectoryLog::make_room() {
  const std::lock_guard lock(mutex_);
  records_.make_room();
}

FrameRecord* TrajectoryLog::find(int64_t frame) {
  const auto records = records_.all();
  const auto record = std::ranges::lower_bound(records, frame, {}, &FrameRecord::frame);
  return record == records.end() || (*record).frame != frame ? nullptr : &*record;
}

void TrajectoryLog::locate(const LocatedFrame& located) {
  const std::lock_guard lock(mutex_);
  FrameRecord* record = find(located.frame);
  if (!record || record->pose) return;
  ++revision_;
  record->pose = located.pose;
}

void TrajectoryLog::anchor(int64_t frame, const RelativePose& pose, const std::optional<SubmapPose>& online) {
  const std::lock_guard lock(mutex_);
  FrameRecord* record = find(frame);
  if (!record) return;
  ++revision_;
  if (!record->pose && online) record->online = online;
  record->pose = pose;
  record->shutter = {};
}

std::optional<Timestamp> TrajectoryLog::retract(int64_t from) {
  const std::lock_guard lock(mutex_);
  ++revision_;
  std::optional<Timestamp> first;
  for (size_t k = records_.size(); k > 0 && records_[k - 1].frame >= from; --k) {
    if (records_[k - 1].pose) first = records_[k - 1].stamp;
    take_back(records_[k - 1]);
  }
  return first;
}

void TrajectoryLog::forget(const Map& map, uint32_t submap) {
  const std::lock_guard lock(mutex_);
  ++revision_;
  for (FrameRecord& record : records_.all()) {
    if (!record.pose) continue;
    const auto resolved = record.pose->resolved(map);
    if (resolved && map.at(resolved->key_frame).submap == submap) take_back(record);
  }
  records_.page_out();
}

void TrajectoryLog::follow(const Map& map, const KeyFrameMoves& moves) {
  if (moves.of.empty()) return;
  const std::lock_guard lock(mutex_);
  ++revision_;
  std::vector<KeyFrameMove> own = moves.of;
  std::erase_if(own, [&](const KeyFrameMove& move) {  // an older recording's frames had numbers of their own
    const FrameRecord* record = find(move.frame);
    return !record || !record->pose || record->pose->key_frame != move.key_frame;
  });
  const FramesBetween between(moves.of, std::move(own));
  for (FrameRecord& record : records_.all()) {
    if (!record.pose || record.moves >= moves.moves) continue;
    if (const auto carried = between.carried(map, record.frame, *record.pose)) record.pose = carried;
  }
  records_.page_out();
}

// The caller holds a read guard meanwhile: a look at each frame, once in so many erased key frames, and a chain of
// poses for the few whose key frame was erased since.
std::optional<uint64_t> TrajectoryLog::reanchor(const Map& map) {
  constexpr uint64_t kEvery = 1024;  // erased key frames: some 200 kB of them
  const std::lock_guard lock(mutex_);
  if (map.erasures() < reanchored_at_ + kEvery) return std::nullopt;
  for (FrameRecord& record : records_.all()) {
    if (!record.pose || map.find(record.pose->key_frame)) continue;
    record.pose->T_cr = std::exchange(record.shutter, {}).corrected(record.pose->T_cr, map.camera().row_time);
    if (const auto resolved = record.pose->resolved(map)) record.pose = resolved;
  }
  records_.page_out();
  return std::exchange(reanchored_at_, map.erasures());
}

std::optional<FrameRecord> TrajectoryLog::last() const {
  const std::lock_guard lock(mutex_);
  return records_.empty() ? std::nullopt : std::optional(records_.back());
}

std::vector<FrameRecord> TrajectoryLog::records() const {
  const std::lock_guard lock(mutex_);
  std::vector<FrameRecord> records;
  records.reserve(records_.size());
  for (const FrameRecord& record : records_.all()) records.push_back(record);
  records_.page_out();
  return records;
}

uint64_t TrajectoryLog::revision() const {
  const std::lock_guard lock(mutex_);
  return revision_;
}

}  // namespace covis
