// SPDX-License-Identifier: Apache-2.0
#include "run_summary.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common.h"
#include "covis/core/quantile.h"
#include "resources.h"

namespace covis::app {
namespace {

using nlohmann::json;

template <class Item, class Value>
json spread(const std::vector<Item>& items, Value value) {
  std::vector<double> values;
  for (const Item& item : items) values.push_back(value(item));
  return {{"median", quantile(values, 0.5)}, {"p95", quantile(values, 0.95)}};
}

json to_json(const MappingReport& m) {
  return {{"points_created", m.counts.points_created},
          {"points_fused", m.counts.points_fused},
          {"points_culled", m.counts.points_culled},
          {"key_frames_culled", m.counts.key_frames_culled},
          {"ba_key_frames", m.adjustment.key_frames},
          {"ba_points", m.adjustment.points},
          {"ba_observations", m.adjustment.observations},
          {"ba_interrupted", m.adjustment.interrupted},
          {"loop_candidates", m.loop.candidates},
          {"loop_matches", m.loop.evidence.matches},
          {"loop_inliers", m.loop.evidence.inliers},
          {"loop_found_again", m.loop.evidence.found_again},
          {"loop_closed", m.loop.outcome == LoopOutcome::closed},
          {"maps_joined", m.loop.outcome == LoopOutcome::joined},
          {"loop_query_ms", m.loop.ms.query},
          {"loop_verify_ms", m.loop.ms.verify},
          {"loop_ms", m.loop_ms},
          {"total_ms", m.total_ms}};
}

// What closing a loop and joining two maps have in common.
json to_json(int64_t frame, const LoopReport& report) {
  return {{"frame", frame},
          {"matches", report.evidence.matches},
          {"inliers", report.evidence.inliers},
          {"found_again", report.evidence.found_again},
          {"fused", report.fused},
          {"scale", report.drift.scale},
          {"query_ms", report.ms.query},
          {"verify_ms", report.ms.verify},
          {"correct_ms", report.ms.correct}};
}

json loops(const RunRecord& run) {
  json list = json::array();
  for (size_t k = 0; k < run.mapping.size(); ++k) {
    const LoopReport& loop = run.mapping[k].loop;
    if (loop.outcome != LoopOutcome::closed) continue;
    // Its full bundle adjustment came some key frames later, unless another loop or the end was first.
    double full_ba_ms = 0;
    for (size_t later = k + 1; later < run.mapping.size() && !run.mapping[later].loop.changed_map(); ++later)
      full_ba_ms += run.mapping[later].full_adjustment_ms;
    json& item = list.emplace_back(to_json(run.mapping[k].frame, loop));
    item.update({{"path_m", loop.drift.path},
                 {"correction_m", loop.drift.distance},
                 {"rotation_deg", loop.drift.rotation_deg},
                 {"pose_graph_ms", loop.ms.pose_graph},
                 {"full_ba_ms", full_ba_ms}});
  }
  return list;
}

json merges(const RunRecord& run) {
  json list = json::array();
  for (const MappingReport& m : run.mapping) {
    if (m.loop.outcome != LoopOutcome::joined) continue;
    list.emplace_back(to_json(m.frame, m.loop))["key_frames_moved"] = m.loop.joined_key_frames;
  }
  return list;
}

json submaps_json(const std::vector<SubmapSummary>& submaps) {
  json list = json::array();
  for (const SubmapSummary& map : submaps) {
    list.push_back(
        {{"loaded", map.loaded}, {"frames", map.frames}, {"keyframes", map.key_frames}, {"map_points", map.points}});
  }
  return list;
}

// What a frame's time went to, milliseconds.
constexpr std::pair<const char*, double (*)(const FrameStats&)> kStages[] = {
    {"extract", [](const FrameStats& f) { return f.timing.extract_ms; }},
    {"depth", [](const FrameStats& f) { return f.timing.depth_ms; }},
    {"motion", [](const FrameStats& f) { return f.track.motion_ms; }},
    {"local_update", [](const FrameStats& f) { return f.track.local_update_ms; }},
    {"local_search", [](const FrameStats& f) { return f.track.local_search_ms; }},
    {"pose", [](const FrameStats& f) { return f.track.pose_ms; }},
    {"mapping_wait", [](const FrameStats& f) { return f.timing.wait_ms; }},
    {"decode_wait", [](const FrameStats& f) { return f.decode_ms; }}};

// `map`: the one the frame's pose belongs to, by its place in the summary's list.
json to_json(const FrameStats& f, std::optional<int> map) {
  json line{{"frame", f.frame}, {"stamp", to_seconds(f.stamp)}, {"state", f.state}, {"reason", f.reason}};
  if (map) line["map"] = *map;
  if (!processed(f)) return line;
  line.update({{"method", name(f.track.method)},
               {"features", f.track.features},
               {"matches", f.track.predicted_matches},
               {"local_points", f.track.local_points},
               {"in_view", f.track.local_in_view},
               {"inliers", f.track.inliers},
               {"tentative", f.track.tentative},
               {"key_frame", f.track.key_frame},
               {"tracking_ms", f.tracking_ms()},
               {"cpu_ms", f.cpu_ms}});
  json& ms = line["ms"] = {{"track", f.timing.track_ms}, {"total", f.timing.total_ms}};
  for (const auto& [stage, time] : kStages) ms[stage] = time(f);
  if (f.rss_mb > 0) line["rss_mb"] = f.rss_mb;
  return line;
}

json stage_times(const std::vector<FrameStats>& frames) {
  json times;
  for (const auto& [stage, time] : kStages) times[stage] = spread(frames, time);
  return times;
}

json mapping_times(const RunRecord& run) {
  const auto stage = [&](auto member) { return spread(run.mapping, member); };
  return {{"insert", stage([](const MappingReport& m) { return m.ms.insert; })},
          {"cull_points", stage([](const MappingReport& m) { return m.ms.cull_points; })},
          {"create", stage([](const MappingReport& m) { return m.ms.create; })},
          {"fuse", stage([](const MappingReport& m) { return m.ms.fuse; })},
          {"local_ba", stage([](const MappingReport& m) { return m.ms.adjust; })},
          {"cull_key_frames", stage([](const MappingReport& m) { return m.ms.cull_key_frames; })},
          {"loop", stage([](const MappingReport& m) { return m.loop_ms; })},
          {"total", stage([](const MappingReport& m) { return m.total_ms; })}};
}

// Runs of frames without a pose, each with the reason of its first frame.
json losses(const RunRecord& run) {
  json list = json::array();
  const FrameStats* start = nullptr;
  int64_t last = 0;
  const auto close = [&] {
    if (start)
      list.push_back({{"first", start->frame}, {"last", last}, {"state", start->state}, {"reason", start->reason}});
    start = nullptr;
  };
  for (const FrameStats& frame : run.frames) {
    if (frame.state == "tracking" || (start && start->state != frame.state)) close();
    if (frame.state != "tracking" && !start) start = &frame;
    last = frame.frame;
  }
  close();
  return list;
}

}  // namespace

FrameStats to_stats(const io::Frame& frame, const FrameReport& report, bool localize) {
  FrameStats stats;
  stats.frame = frame.index;
  stats.stamp = frame.stamp;
  stats.state = localize && report.track.state == TrackState::lost ? "not_localised" : name(report.track.state);
  stats.reason = report.track.reason;
  stats.track = report.track;
  stats.timing = report.timing;
  return stats;
}

FrameStats untracked(int64_t frame, Timestamp stamp, const char* state, const std::string& reason) {
  FrameStats stats;
  stats.frame = frame;
  stats.stamp = stamp;
  stats.state = state;
  stats.reason = reason;
  return stats;
}

void mark_taken_back(const System& system, bool localize, std::vector<FrameStats>& frames) {
  auto record = system.records().begin();  // both come in the order of their frames
  for (FrameStats& frame : frames) {
    while (record != system.records().end() && record->frame < frame.frame) ++record;
    if (record == system.records().end()) return;
    if (record->frame != frame.frame || record->tracked || frame.state != "tracking") continue;
    frame.state = localize ? "not_localised" : "lost";
    frame.reason = "its pose was taken back: the place or the map proved wrong";
  }
}

bool processed(const FrameStats& frame) { return frame.state != "late" && frame.state != "unreadable"; }

std::string stats_text(const RunRecord& run, const std::vector<PoseOfFrame>& poses) {
  std::string text;
  size_t next = 0;            // reports of mapping come in the order of their frames
  auto pose = poses.begin();  // so do poses
  for (const FrameStats& frame : run.frames) {
    while (pose != poses.end() && pose->frame < frame.frame) ++pose;
    const bool has_pose = pose != poses.end() && pose->frame == frame.frame;
    json line = to_json(frame, has_pose ? std::optional(pose->submap_index) : std::nullopt);
    for (; next < run.mapping.size() && run.mapping[next].frame <= frame.frame; ++next) {
      if (run.mapping[next].frame == frame.frame) line["mapping"] = to_json(run.mapping[next]);
    }
    // A message may quote a file name that is not UTF-8.
    text += line.dump(-1, ' ', false, json::error_handler_t::replace);
    text += '\n';
  }
  return text;
}

json summarise(const RunRecord& run, const System& system) {
  std::vector<FrameStats> done;
  for (const FrameStats& f : run.frames) {
    if (processed(f)) done.push_back(f);
  }
  const auto tracked =
      std::count_if(system.records().begin(), system.records().end(), [](const FrameRecord& r) { return r.tracked; });
  const auto online =
      std::count_if(system.records().begin(), system.records().end(), [](const FrameRecord& r) { return r.online; });
  const auto first_tracked =
      std::find_if(system.records().begin(), system.records().end(), [](const FrameRecord& r) { return r.online; });
  size_t key_frames = 0, points = 0;
  for (const SubmapSummary& map : system.submaps()) {
    key_frames += map.key_frames;
    points += map.points;
  }
  const Pinhole camera = system.camera();
  return {{"source", run.source},
          {"sensor", name_of(kSensors, run.sensor)},
          {"camera", {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}}},
          {"frames", run.frames.size()},
          {"frames_tracked", tracked},
          {"frames_tracked_online", online},
          {"first_tracked_frame", first_tracked == system.records().end() ? -1 : first_tracked->frame},
          {"frames_late", run.late_frames},
          {"frames_unreadable", run.unreadable_frames},
          {"interrupted", run.interrupted},
          {"keyframes", key_frames},
          {"keyframes_made", run.mapping.size()},
          {"map_points", points},
          {"refused_non_finite", system.map().read()->refused_non_finite()},
          {"tracking_ms", spread(done, [](const FrameStats& f) { return f.tracking_ms(); })},
          {"frame_ms", spread(done, [](const FrameStats& f) { return f.timing.total_ms; })},
          {"cpu_ms", spread(done, [](const FrameStats& f) { return f.cpu_ms; })},
          {"stage_ms", stage_times(done)},
          {"mapping_ms", mapping_times(run)},
          {"loops", loops(run)},
          {"maps", submaps_json(system.submaps())},
          {"merges", merges(run)},
          {"frames_per_second", static_cast<double>(run.frames.size()) / std::max(run.wall_seconds, 1e-9)},
          {"wall_s", run.wall_seconds},
          {"first_pose_ms", run.first_pose_ms},
          {"peak_rss_mb", peak_rss_mb()},
          {"not_tracked", losses(run)}};
}

}  // namespace covis::app
