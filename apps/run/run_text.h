// SPDX-License-Identifier: Apache-2.0
// The main figures of a run in words, for the terminal and for the report's table.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/run_summary.h"

namespace covis::app {

// Says why a run has no pose: what is odd about the camera, else the commonest reason of its frames.
std::string why_nothing_is_tracked(const RunSummary& summary, const Camera& camera);
// Returns a few lines of text. out: the folder of the results.
std::string summary_text(const RunSummary& summary, const std::filesystem::path& out);
std::vector<std::pair<std::string, std::string>> summary_rows(const RunSummary& summary);

}  // namespace covis::app
