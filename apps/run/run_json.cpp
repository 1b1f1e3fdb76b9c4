// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_json.h"

#include <nlohmann/json.hpp>
#include <optional>

namespace covis::app {
namespace {

using nlohmann::json;

json to_json(const LoopDrift& drift) {
  return {{"path_m", drift.path},
          {"past_m", drift.past},
          {"correction_m", drift.distance},
          {"rotation_deg", drift.rotation_deg},
          {"scale", drift.scale}};
}

json to_json(const LoopEvidence& evidence) {
  return {{"matches", evidence.matches},
          {"inliers", evidence.inliers},
          {"both_ways", evidence.both_ways},
          {"found_again", evidence.found_again},
          {"in_view", evidence.in_view}};
}

// The places that were no loop, and why.
json to_json(const std::vector<RefusedPlace>& places) {
  json list = json::array();
  for (const RefusedPlace& place : places) {
    json& line = list.emplace_back(to_json(place.evidence));
    line.update({{"frame", place.frame}, {"reason", name(place.why)}});
    if (place.drift) line.update(to_json(*place.drift));
    if (place.link) line["weakest_link"] = *place.link;
  }
  return list;
}

json to_json(const MappingReport& m) {
  return {{"points_created", m.counts.points_created},
          {"points_fused", m.counts.points_fused},
          {"points_culled", m.counts.points_culled},
          {"key_frames_culled", m.counts.key_frames_culled},
          {"key_frames_thinned", m.counts.key_frames_thinned},
          {"ba_key_frames", m.adjustment.key_frames},
          {"ba_points", m.adjustment.points},
          {"ba_observations", m.adjustment.observations},
          {"ba_interrupted", m.adjustment.interrupted},
          {"loop_candidates", m.loop.candidates},
          {"loop_matches", m.loop.evidence.matches},
          {"loop_inliers", m.loop.evidence.inliers},
          {"loop_found_again", m.loop.evidence.found_again},
          {"loop_refused", to_json(m.loop.refused)},
          {"loop_closed", m.loop.outcome == LoopOutcome::closed},
          {"maps_joined", m.loop.outcome == LoopOutcome::joined},
          {"loop_query_ms", m.loop.ms.query},
          {"loop_verify_ms", m.loop.ms.verify},
          {"loop_ms", m.loop_ms},
          {"total_ms", m.total_ms}};
}

// The figures common to closing a loop and joining two maps.
json to_json(const LoopSummary& loop) {
  const LoopReport& report = loop.report;
  json line = to_json(report.evidence);
  line.update({{"frame", loop.frame},
               {"fused", report.fused},
               {"scale", report.drift.scale},
               {"query_ms", report.ms.query},
               {"verify_ms", report.ms.verify},
               {"correct_ms", report.ms.correct}});
  return line;
}

json loops_json(const std::vector<LoopSummary>& loops) {
  json list = json::array();
  for (const LoopSummary& loop : loops) {
    json& line = list.emplace_back(to_json(loop));
    line.update(to_json(loop.report.drift));
    line.update({{"confirmed", loop.report.confirmed},
                 {"unexplained", loop.report.unexplained},
                 {"new_edges", loop.report.new_edges},
                 {"pose_graph_ms", loop.report.ms.pose_graph},
                 {"full_ba_ms", loop.full_ba_ms}});
  }
  return list;
}

json merges_json(const std::vector<LoopSummary>& merges) {
  json list = json::array();
  for (const LoopSummary& merge : merges)
    list.emplace_back(to_json(merge))["key_frames_moved"] = merge.report.joined ? merge.report.joined->key_frames : 0;
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

json losses_json(const std::vector<Loss>& losses) {
  json list = json::array();
  for (const Loss& loss : losses)
    list.push_back({{"first", loss.first}, {"last", loss.last}, {"state", name(loss.state)}, {"reason", loss.reason}});
  return list;
}

json warnings_json(const RunSummary& s) {
  json list = json::array();
  for (const SensorWarning& w : s.warnings) {
    list.push_back(
        {{"frame", w.frame}, {"kind", name(w.doubt)}, {"figure", w.figure}, {"text", describe(w, s.sensor)}});
  }
  return list;
}

json to_json(const Spread& spread) { return {{"median", spread.median}, {"p95", spread.p95}}; }

json to_json(const std::vector<std::pair<const char*, Spread>>& stages) {
  json times;
  for (const auto& [stage, spread] : stages) times[stage] = to_json(spread);
  return times;
}

// map: index in the summary's list of the map to which the frame's pose belongs.
json to_json(const FrameStats& f, std::optional<int> map) {
  json line{{"frame", f.frame}, {"stamp", to_seconds(f.stamp)}, {"state", name(f.state)}, {"reason", f.reason}};
  if (map) line["map"] = *map;
  if (!f.processed()) return line;
  line.update({{"method", name(f.track.method)},
               {"features", f.track.features},
               {"matches", f.track.predicted_matches},
               {"local_points", f.track.local_points},
               {"first_share", f.track.first_share},
               {"in_view", f.track.local_in_view},
               {"expected", f.track.local_expected},
               {"inliers", f.track.inliers},
               {"tentative", f.track.tentative},
               {"key_frame", f.track.key_frame},
               {"tracking_ms", f.tracking_ms()},
               {"cpu_ms", f.cpu_ms}});
  json& ms = line["ms"] = {{"track", f.timing.track_ms}, {"total", f.timing.total_ms}};
  for (const Stage& stage : kStages) ms[stage.name] = stage.ms(f);
  if (f.rss_mb > 0) line["rss_mb"] = f.rss_mb;
  return line;
}

json online_json(const SubmapPose& pose) {
  const Eigen::Vector3d& t = pose.T_wc.t();
  return {{"submap", pose.submap}, {"position_m", {t.x(), t.y(), t.z()}}};
}

// Poses asked for by rising frame.
class PosesInOrder {
 public:
  explicit PosesInOrder(const std::vector<PoseOfFrame>& poses) : next_(poses.begin()), end_(poses.end()) {}
  // Null when the frame has none.
  const PoseOfFrame* of(int64_t frame) {
    while (next_ != end_ && next_->frame < frame) ++next_;
    return next_ != end_ && next_->frame == frame ? &*next_ : nullptr;
  }

 private:
  std::vector<PoseOfFrame>::const_iterator next_, end_;
};

}  // namespace

void append_stats(const RunRecord& run, const Snapshot& snapshot, FileSink& sink) {
  size_t next = 0;  // next mapping report; they are in the order of their frames
  PosesInOrder poses(snapshot.trajectory), online(snapshot.online);
  for (const FrameStats& frame : run.frames.all()) {
    const PoseOfFrame* pose = poses.of(frame.frame);
    json line = to_json(frame, pose ? snapshot.index_of(pose->submap) : std::nullopt);
    if (const PoseOfFrame* tracked = online.of(frame.frame)) line["online"] = online_json(*tracked);
    for (; next < run.mapping.size() && run.mapping[next].frame <= frame.frame; ++next) {
      if (run.mapping[next].frame == frame.frame) line["mapping"] = to_json(run.mapping[next]);
    }
    // A message may quote a file name that is not UTF-8.
    sink.append(line.dump(-1, ' ', false, json::error_handler_t::replace) + '\n');
  }
}

json pinhole_json(const Pinhole& camera, int height) {
  json figures{{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}};
  if (camera.residual.any()) figures.update({{"k1", camera.residual.k1}, {"k2", camera.residual.k2}});
  if (const DepthRegistration& r = camera.registration; r.any()) {
    figures["depth_registration"] = {
        {"scale", r.scale}, {"shift", {r.shift_x, r.shift_y}}, {"parallax", {r.parallax_x, r.parallax_y}}};
  }
  if (camera.row_time != 0) figures["readout"] = camera.row_time * height;
  if (camera.depth_noise.known())
    figures.update({{"depth_sigma_a", camera.depth_noise.a}, {"depth_sigma_b", camera.depth_noise.b}});
  return figures;
}

json estimate_json(const CameraEstimate& estimate) {
  return {{"file", estimate.file.string()},
          {"focal_sigma", estimate.sigma.focal},
          {"k1", estimate.k1},
          {"k1_sigma", estimate.sigma.k1},
          {"k2", estimate.k2},
          {"k2_sigma", estimate.sigma.k2},
          {"cx_sigma", estimate.sigma.cx},
          {"cy_sigma", estimate.sigma.cy}};
}

json to_json(const RunSummary& s) {
  json all{{"source", s.source},
           {"sensor", name(s.sensor)},
           {"camera", pinhole_json(s.camera, s.image_height)},
           {"camera_given", pinhole_json(s.given, s.image_height)},
           {"frames", s.frames.all},
           {"frames_tracked", s.frames.tracked},
           {"frames_tracked_online", s.frames.tracked_online},
           {"first_tracked_frame", s.frames.first_tracked},
           {"frames_late", s.frames.late},
           {"frames_unreadable", s.frames.unreadable},
           {"frames_dropped", s.frames.dropped},
           {"camera_gone", s.frames.camera_gone},
           {"interrupted", s.interrupted},
           {"keyframes", s.map.key_frames},
           {"keyframes_made", s.map.key_frames_made},
           {"keyframes_thinned", s.map.key_frames_thinned},
           {"map_points", s.map.points},
           {"refused_non_finite", s.map.refused_non_finite},
           {"tracking_ms", to_json(s.times.tracking)},
           {"frame_ms", to_json(s.times.frame)},
           {"cpu_ms", to_json(s.times.cpu)},
           {"stage_ms", to_json(s.times.stages)},
           {"mapping_ms", to_json(s.times.mapping)},
           {"loops", loops_json(s.loops)},
           {"maps", submaps_json(s.map.submaps)},
           {"merges", merges_json(s.merges)},
           {"frames_per_second", s.costs.frames_per_second},
           {"wall_s", s.costs.wall_seconds},
           {"first_pose_ms", s.costs.first_pose_ms},
           {"peak_rss_mb", s.costs.peak_rss_mb},
           {"not_tracked", losses_json(s.not_tracked)},
           {"warnings", warnings_json(s)}};
  if (!s.notes.empty()) all["notes"] = s.notes;
  if (!s.failure.empty()) all["failure"] = s.failure;
  if (s.estimate) all["camera_estimate"] = estimate_json(*s.estimate);
  if (!s.accuracy) return all;
  const Accuracy& a = *s.accuracy;
  all.update({{"ate_m", a.ate},
              {"ate_online_m", a.ate_online},
              {"ate_alignment", name_of_alignment(a.alignment)},
              {"truth_path_m", a.path_length}});
  if (a.scaled) all.update({{"ate_sim3_m", a.scaled->ate}, {"scale", a.scaled->scale}});
  return all;
}

}  // namespace covis::app
