// SPDX-License-Identifier: Apache-2.0
// JSON of a run: summary.json, and stats.jsonl with one line per frame.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "apps/run/run_summary.h"
#include "covis/core/atomic_file.h"
#include "covis/geometry/camera.h"

namespace covis::app {

nlohmann::json to_json(const RunSummary& summary);
// height: of its images, pixels.
nlohmann::json pinhole_json(const Pinhole& camera, int height);

// A line for each frame, with the mapping done for it and the submap its pose belongs to.
void append_stats(const RunRecord& run, const Snapshot& snapshot, FileSink& sink);

}  // namespace covis::app
