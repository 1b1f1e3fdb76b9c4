// SPDX-License-Identifier: Apache-2.0
// The report of a run, and of a comparison with the truth, for people: pictures and figures in one HTML file that needs
// nothing else.
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
  std::string loss, reason;  // a frame without a pose: its state, and why; empty when it has one
  double tracking_ms = 0;
  int inliers = 0;
  bool key_frame = false;
};

struct ReportInput {
  std::string title;
  Trajectory estimate, key_frames;
  const Trajectory* truth = nullptr;  // may be null
  AlignMode align = AlignMode::se3;   // to the truth
  std::vector<Eigen::Vector3d> points;
  std::vector<ReportFrame> frames;
  std::vector<std::pair<std::string, std::string>> summary;  // rows of a table
};

// Writes report.html and trajectory.png into a folder.
Result<void> write_report(const std::filesystem::path& folder, const ReportInput& input);

// Writes the picture of an evaluation, the path from above beside the truth and the error over time: as PNG, or with
// the table as a page when the file is named .html. Error: another ending.
Result<void> write_picture(const std::filesystem::path& file, const std::string& title, const Evaluation& evaluation);

}  // namespace covis
