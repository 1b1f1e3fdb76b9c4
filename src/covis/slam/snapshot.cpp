// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/snapshot.h"

#include <algorithm>
#include <iterator>
#include <unordered_map>

namespace covis {
namespace {

SubmapSummary& summary_of(uint32_t submap, Snapshot& snapshot) { return snapshot.submaps[*snapshot.index_of(submap)]; }

void add_submaps(const Map& map, uint32_t loaded_end, Snapshot& snapshot) {
  for (const Submap& submap : map.submaps())
    snapshot.submaps.push_back({submap.id, submap.id < loaded_end, 0, submap.key_frames, 0});
}

// Snapshot::KeyFrame::camera; the camera is added to the others where it is new.
uint32_t camera_of(const Features& features, std::vector<RefinedCamera>& others) {
  if (!features.made_by) return 0;
  const auto at = std::find(others.begin(), others.end(), *features.made_by);
  const auto number = static_cast<uint32_t>(at - others.begin()) + 1;
  if (at == others.end()) others.push_back(*features.made_by);
  return number;
}

void add_key_frames(const Map& map, Snapshot& snapshot) {
  snapshot.key_frames.reserve(map.key_frame_count());
  for (const KeyFrameId& id : map.key_frames()) {
    const KeyFrame& from = map.at(id);
    Snapshot::KeyFrame& key_frame = snapshot.key_frames.emplace_back();
    key_frame.T_wc = from.T_cw.inverse();
    key_frame.submap = from.submap;
    key_frame.frame = from.frame;
    key_frame.stamp = from.stamp;
    key_frame.id = id;
    key_frame.parent = from.parent;
    key_frame.serial = from.serial;
    key_frame.camera = camera_of(*from.features, snapshot.other_cameras);
  }
}

// The index of each thing of a list, by its handle's slot; one slot has one live handle.
template <class List>
std::vector<uint32_t> index_by_slot(const List& list) {
  std::vector<uint32_t> index;
  for (uint32_t k = 0; k < list.size(); ++k) {
    const size_t slot = list[k].id.slot;
    if (slot >= index.size()) index.resize(slot + 1);
    index[slot] = k;
  }
  return index;
}

void add_edges(const Map& map, const std::vector<uint32_t>& index, Snapshot& snapshot) {
  for (uint32_t a = 0; a < snapshot.key_frames.size(); ++a) {
    const KeyFrame& from = map.at(snapshot.key_frames[a].id);
    const auto loops_to = [&](KeyFrameId other) {
      return std::binary_search(from.loop_edges.begin(), from.loop_edges.end(), other);
    };
    for (const Neighbour& n : from.shared) {
      const uint32_t b = index[n.key_frame.slot];
      if (a < b && (n.weight >= kCovisibilityThreshold || loops_to(n.key_frame)))
        snapshot.edges.push_back({a, b, n.weight, loops_to(n.key_frame)});
    }
    // Key frames that a loop ties need not share points.
    for (const KeyFrameId& other : from.loop_edges) {
      const uint32_t b = index[other.slot];
      if (a < b && map.weight(snapshot.key_frames[a].id, other) == 0) snapshot.edges.push_back({a, b, 0, true});
    }
  }
}

// And the points' colours, which their observers have.
void add_observations(const Map& map, Snapshot& snapshot) {
  const std::vector<uint32_t> point_index = index_by_slot(snapshot.points);
  MeanColours colours(snapshot.points.size());
  for (uint32_t k = 0; k < snapshot.key_frames.size(); ++k) {
    const KeyFrame& key_frame = map.at(snapshot.key_frames[k].id);
    const auto &u = key_frame.features->image_x(), &v = key_frame.features->image_y();
    for (size_t f = 0; f < key_frame.points.size(); ++f) {
      const MapPointId point = key_frame.points[f];
      if (!point.valid()) continue;
      snapshot.observations.push_back({k, point_index[point.slot], u[f], v[f]});
      if (key_frame.colours) colours.add(point_index[point.slot], (*key_frame.colours)[f]);
    }
  }
  for (size_t i = 0; i < snapshot.points.size(); ++i) snapshot.points[i].colour = colours.mean(i);
}

void add_points(const Map& map, Snapshot& snapshot) {
  snapshot.points.reserve(map.point_count());
  map.for_each_point([&](MapPointId id, const MapPoint& point) {
    const uint32_t submap = map.at(point.reference).submap;
    snapshot.points.push_back({id, point.position_w, submap, kNoColour});
  });
}

// A key frame that frames refer to, or the one that lives in its place.
struct Reference {
  Map::Resolved living;
  SE3 T_rw;  // its pose
  uint32_t submap = 0;
};
using References = std::unordered_map<KeyFrameId, Reference>;

// Many frames refer to one key frame, which is looked for once.
References references_of(const Map& map, const std::vector<FrameRecord>& records) {
  References references;
  KeyFrameId last;
  for (const FrameRecord& record : records) {
    if (!record.pose || record.pose->key_frame == last) continue;
    last = record.pose->key_frame;
    const auto living = references.contains(last) ? std::nullopt : map.resolve(last);
    if (!living) continue;
    const KeyFrame& key_frame = map.at(living->key_frame);
    references.emplace(last, Reference{*living, key_frame.T_cw, key_frame.submap});
  }
  return references;
}

void add_frames(const References& references, const std::vector<FrameRecord>& records, Snapshot& snapshot) {
  const auto pose_of = [](const FrameRecord& record, const SubmapPose& pose) {
    return PoseOfFrame{pose, record.frame, record.stamp};
  };
  snapshot.trajectory.reserve(records.size());
  snapshot.online.reserve(records.size());
  for (const FrameRecord& record : records) {
    if (record.online) snapshot.online.push_back(pose_of(record, *record.online));
    if (!record.pose) continue;
    const auto found = references.find(record.pose->key_frame);
    if (found == references.end()) continue;
    const Reference& reference = found->second;
    const SE3 T_cr = record.shutter.corrected(record.pose->T_cr, snapshot.camera.row_time);
    const SE3 T_cw = reference.living.carry(T_cr, record.pose->scale) * reference.T_rw;
    snapshot.trajectory.push_back(pose_of(record, {T_cw.inverse(), reference.submap}));
  }
}

void count(Snapshot& snapshot) {
  for (const Snapshot::Point& point : snapshot.points) ++summary_of(point.submap, snapshot).points;
  for (const PoseOfFrame& pose : snapshot.trajectory) ++summary_of(pose.submap, snapshot).frames;
}

void sort_submaps(Snapshot& snapshot) {
  std::stable_sort(snapshot.submaps.begin(), snapshot.submaps.end(),
                   [](const auto& a, const auto& b) { return a.loaded != b.loaded ? a.loaded : a.frames > b.frames; });
}

}  // namespace

std::optional<size_t> Snapshot::index_of(uint32_t submap) const {
  const auto found =
      std::find_if(submaps.begin(), submaps.end(), [&](const SubmapSummary& s) { return s.id == submap; });
  if (found == submaps.end()) return std::nullopt;
  return static_cast<size_t>(found - submaps.begin());
}

std::vector<PoseOfFrame> poses_in(const std::vector<PoseOfFrame>& poses, std::optional<uint32_t> submap) {
  std::vector<PoseOfFrame> inside;
  std::copy_if(poses.begin(), poses.end(), std::back_inserter(inside),
               [&](const PoseOfFrame& pose) { return submap && pose.submap == *submap; });
  return inside;
}

void SnapshotSource::map_loaded(uint32_t loaded_end) {
  const std::lock_guard lock(mutex_);
  latest_.reset();
  loaded_end_ = loaded_end;
}

Pinhole SnapshotSource::camera() const { return map_.read()->camera(); }

std::vector<PoseOfFrame> SnapshotSource::trajectory() const {
  const std::vector<FrameRecord> records = log_.records();
  Snapshot snapshot;
  References references;
  {
    const auto map = map_.read();
    snapshot.camera = map->camera();
    references = references_of(*map, records);
  }
  add_frames(references, records, snapshot);
  return std::move(snapshot.trajectory);
}

std::shared_ptr<const Snapshot> SnapshotSource::get() const {
  const std::lock_guard lock(mutex_);
  // Neither count falls, so the sum is the same only when both are. Both are read before what they count: a change in
  // between makes the snapshot newer than its revision, and the next one is made anew.
  const uint64_t revision = map_.revision() + log_.revision();
  if (latest_ && latest_->revision == revision) return latest_;
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = revision;
  const std::vector<FrameRecord> records = log_.records();
  References references;
  {
    // Copies alone: mapping waits for the guard. The poses of frames are worked out after it.
    const auto map = map_.read();
    snapshot->camera = map->camera();
    snapshot->refused_non_finite = map->refused_non_finite();
    add_submaps(*map, loaded_end_, *snapshot);
    add_key_frames(*map, *snapshot);
    add_points(*map, *snapshot);
    add_edges(*map, index_by_slot(snapshot->key_frames), *snapshot);
    add_observations(*map, *snapshot);
    references = references_of(*map, records);
  }
  add_frames(references, records, *snapshot);
  count(*snapshot);
  sort_submaps(*snapshot);
  latest_ = snapshot;
  return latest_;
}

}  // namespace covis
