// SPDX-License-Identifier: Apache-2.0
// The output files of `covis run`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/run/run_summary.h"
#include "covis/core/error.h"
#include "covis/io/outputs.h"
#include "covis/io/sequence.h"
#include "covis/io/trajectory.h"

namespace covis::app {

struct OutputOptions {
  std::filesystem::path directory;
  io::TrajectoryFormat format = io::TrajectoryFormat::tum;
  std::string title;
  const Trajectory* truth = nullptr;  // ground truth of the camera; may be null
  // The unit of map.ply, which is that of the map: one camera alone may be localised in a map in metres.
  io::CloudUnit unit = io::CloudUnit::metres;
};

// Makes the folder. Error: it can't be made or written to, or a file that write_outputs() would write there is one of
// those given, or of another kind.
Result<void> open_output_folder(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& given);

// Says why a run has nothing worth writing to the folder: no frame could be read, or it failed before it tracked one
// and an earlier run's results are there, which stay. nullopt: its results are to be written.
std::optional<std::string> why_nothing_is_written(const RunRecord& run, const Snapshot& snapshot,
                                                  const std::filesystem::path& folder);

// Returns nullopt when there is no ground truth, or when it cannot be read; the latter logs a warning.
std::optional<Trajectory> read_truth(const io::Sequence& sequence);

// Writes trajectory.txt, trajectory_online.txt, keyframes.txt and map.ply of the main map, trajectory_map1.txt and so
// on of maps not joined to it, the stamps of each trajectory beside it where its format has none, stats.jsonl,
// summary.json, scene.bin, report.html and trajectory.png. Each file is written whole or not at all; the first that
// fails is the error, the others are written all the same.
Result<void> write_outputs(const RunRecord& run, const Snapshot& snapshot, const RunSummary& summary,
                           const OutputOptions& options);

}  // namespace covis::app
