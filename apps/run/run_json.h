// SPDX-License-Identifier: Apache-2.0
// JSON of a run: summary.json, and stats.jsonl with one line per frame.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/run/run_summary.h"

namespace covis::app {

nlohmann::json to_json(const RunSummary& summary);

// One line per frame, with the mapping done for it and the map its pose belongs to.
std::string stats_text(const RunRecord& run, const std::vector<PoseOfFrame>& poses);

}  // namespace covis::app
