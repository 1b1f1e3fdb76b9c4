// SPDX-License-Identifier: Apache-2.0
#include "apps/view/run_log.h"

#include <utility>

namespace covis::view {
namespace {

constexpr size_t kMostTexts = 65536;

}  // namespace

void RunLog::add(FrameRow row, const std::string& reason) {
  if (!reason.empty() && !index_of_text_.contains(reason)) add_text(reason);
  const auto found = index_of_text_.find(reason);
  row.reason = found == index_of_text_.end() ? uint16_t{0} : found->second;
  frames_.push_back(row);
}

void RunLog::add_text(std::string text) {
  if (texts_.size() >= kMostTexts) return;
  index_of_text_.emplace(text, static_cast<uint16_t>(texts_.size()));
  texts_.push_back(std::move(text));
}

void RunLog::set_loops(const std::vector<LoopPaths>& loops) {
  loop_versions_.resize(loops.size());
  for (size_t k = 0; k < loops.size(); ++k) {
    if (k >= loops_.size() || loops_[k].after != loops[k].after) ++loop_versions_[k];
  }
  loops_ = loops;
}

}  // namespace covis::view
