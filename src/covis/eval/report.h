// SPDX-License-Identifier: Apache-2.0
// The report of a run and of a comparison with the ground truth, for people: pictures and figures in one self-contained
// HTML file.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "covis/core/error.h"
#include "covis/eval/evaluation.h"

namespace covis {

struct ReportFrame {
  int64_t index = 0;
  std::string loss, reason;  // for a frame without a pose, its state and the reason; empty when it has a pose
  double tracking_ms = 0;
  int inliers = 0;
  bool key_frame = false;
};

struct ReportInput {
  std::string title;
  Trajectory estimate, key_frames;
  const Trajectory* truth = nullptr;  // may be null
  AlignMode align = AlignMode::se3;   // alignment to the ground truth
  std::vector<Eigen::Vector3d> points;
  std::vector<ReportFrame> frames;
  std::vector<std::pair<std::string, std::string>> summary;  // rows of a table
  std::string viewer;  // HTML that shows the map and charts of each frame; empty: they are drawn as pictures
};

// Writes report.html and trajectory.png into a folder.
Result<void> write_report(const std::filesystem::path& folder, const ReportInput& input);

// Writes the picture of an evaluation, the path from above beside the ground truth and the error over time: as PNG, or
// together with the table as an HTML page when the file is named .html. Any other extension is an error.
Result<void> write_picture(const std::filesystem::path& file, const std::string& title, const Evaluation& evaluation);

}  // namespace covis
