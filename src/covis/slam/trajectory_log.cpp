// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/trajectory_log.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace covis {
namespace {

constexpr size_t kFrames = 1 << 14;  // room made at first; pages of it are used only when frames come

void take_back(FrameRecord& record) {
  record.pose.reset();
  record.online.reset();
}

}  // namespace

TrajectoryLog::TrajectoryLog(size_t most) : most_(most) {
  records_.reserve(most > 0 ? std::min(2 * most, kFrames) : kFrames);
}

void TrajectoryLog::append(const FrameRecord& record) {
  const std::lock_guard lock(mutex_);
  ++revision_;
  if (most_ > 0 && records_.size() == 2 * most_)
    records_.erase(records_.begin(), records_.end() - static_cast<std::ptrdiff_t>(most_));
  records_.push_back(record);
}

void TrajectoryLog::make_room() {
  const std::lock_guard lock(mutex_);
  const size_t room = records_.capacity();
  if (2 * records_.size() <= room) return;
  records_.reserve(most_ > 0 ? std::max(room, std::min(2 * room, 2 * most_)) : 2 * room);
}

FrameRecord* TrajectoryLog::find(int64_t frame) {
  const auto record = std::lower_bound(records_.begin(), records_.end(), frame,
                                       [](const FrameRecord& r, int64_t wanted) { return r.frame < wanted; });
  return record == records_.end() || record->frame != frame ? nullptr : &*record;
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
}

std::optional<Timestamp> TrajectoryLog::retract(int64_t from) {
  const std::lock_guard lock(mutex_);
  ++revision_;
  std::optional<Timestamp> first;
  for (auto record = records_.rbegin(); record != records_.rend() && record->frame >= from; ++record) {
    if (record->pose) first = record->stamp;
    take_back(*record);
  }
  return first;
}

void TrajectoryLog::forget(const Map& map, uint32_t submap) {
  const std::lock_guard lock(mutex_);
  ++revision_;
  for (FrameRecord& record : records_) {
    if (!record.pose) continue;
    const auto resolved = record.pose->resolved(map);
    if (resolved && map.at(resolved->key_frame).submap == submap) take_back(record);
  }
}

// The caller holds a read guard meanwhile: a look at each frame, once in so many erased key frames, and a chain of
// poses for the few whose key frame was erased since.
std::optional<uint64_t> TrajectoryLog::reanchor(const Map& map) {
  constexpr uint64_t kEvery = 1024;  // erased key frames: some 200 kB of them
  const std::lock_guard lock(mutex_);
  if (map.erasures() < reanchored_at_ + kEvery) return std::nullopt;
  for (FrameRecord& record : records_) {
    if (!record.pose || map.find(record.pose->key_frame)) continue;
    if (const auto resolved = record.pose->resolved(map)) record.pose = resolved;
  }
  return std::exchange(reanchored_at_, map.erasures());
}

std::optional<FrameRecord> TrajectoryLog::last() const {
  const std::lock_guard lock(mutex_);
  return records_.empty() ? std::nullopt : std::optional(records_.back());
}

std::vector<FrameRecord> TrajectoryLog::records() const {
  const std::lock_guard lock(mutex_);
  return records_;
}

uint64_t TrajectoryLog::revision() const {
  const std::lock_guard lock(mutex_);
  return revision_;
}

}  // namespace covis
