// SPDX-License-Identifier: Apache-2.0
// A run as the viewer shows it (apps/view).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "apps/run/run_record.h"
#include "apps/run/run_summary.h"
#include "apps/view/view_state.h"

namespace covis::app {

// Returns the row without a pose.
view::FrameRow row_of(const FrameStats& stats);

// The page's knowledge of a run before any frame. mode: "live", "finished" or "map".
nlohmann::json view_info(const RunRecord& run, const std::string& title, const std::string& mode);

// The state at the end of a run.
view::ViewState view_state(const RunRecord& run, const Snapshot& snapshot, const RunSummary& summary,
                           const std::string& title);

}  // namespace covis::app
