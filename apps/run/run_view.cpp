// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_view.h"

#include <nlohmann/json.hpp>

#include "apps/run/run_json.h"
#include "apps/run/run_text.h"

namespace covis::app {
namespace {

constexpr FrameState kStates[] = {FrameState::tracking,      FrameState::lost, FrameState::not_initialised,
                                  FrameState::not_localised, FrameState::late, FrameState::unreadable,
                                  FrameState::camera_gone};

}  // namespace

view::FrameRow row_of(const FrameStats& stats) {
  view::FrameRow row;
  row.frame = static_cast<int32_t>(stats.frame);
  row.state = static_cast<uint8_t>(stats.state);
  row.stamp = to_seconds(stats.stamp);
  if (!stats.processed()) return row;
  if (stats.track.key_frame) row.flags |= view::FrameRow::kKeyFrame;
  if (stats.track.tentative) row.flags |= view::FrameRow::kTentative;
  row.inliers = stats.track.inliers;
  row.features = stats.track.features;
  row.tracking_ms = static_cast<float>(stats.tracking_ms());
  row.total_ms = static_cast<float>(stats.timing.total_ms);
  return row;
}

nlohmann::json view_info(const RunRecord& run, const std::string& title, const std::string& mode) {
  nlohmann::json states = nlohmann::json::array();
  for (const FrameState state : kStates) states.push_back(name(state));
  nlohmann::json camera = pinhole_json(run.given, run.image_height);
  camera["width"] = run.image_width;
  camera["height"] = run.image_height;
  return {{"title", title},   {"mode", mode},     {"source", run.source},
          {"states", states}, {"camera", camera}, {"sensor", name(run.sensor)}};
}

view::ViewState view_state(const RunRecord& run, const Snapshot& snapshot, const RunSummary& summary,
                           const std::string& title) {
  view::ViewState state;
  nlohmann::json info = view_info(run, title, "finished");
  info["summary"] = summary_rows(summary);
  state.info = info.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  auto online = snapshot.online.begin();
  for (const FrameStats& stats : run.frames.all()) {
    view::FrameRow row = row_of(stats);
    while (online != snapshot.online.end() && online->frame < stats.frame) ++online;
    if (online != snapshot.online.end() && online->frame == stats.frame) {
      row.flags |= view::FrameRow::kHasPose;
      row.pose = view::row_of(online->T_wc);
      row.submap = online->submap;
    }
    state.log.add(row, stats.reason);
  }
  state.log.set_loops(run.loops);
  state.map = std::make_shared<const view::MapScene>(view::scene_of(snapshot));
  return state;
}

}  // namespace covis::app
