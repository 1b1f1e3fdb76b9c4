// SPDX-License-Identifier: Apache-2.0
// The error that a pair's rectification left in the columns of the right image, found while the map is small. Columns
// that are off by a tenth of a pixel make what is far away nearer or farther by percents, and a path too long or too
// short. Measured figures: docs/notes/063-what-rectification-left.md.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "covis/loops/background_adjustment.h"
#include "covis/mapping/map_problem.h"

namespace covis {

// Moves an adjusted problem to the columns that its observations show: by a field that moves them by 0.1 pixels (root
// mean square) and so many standard deviations at least, or, where one is known, by whatever more observations say
// otherwise. False: the problem stays as it was.
bool refine_columns(BundleProblem& problem, BundleAdjuster& adjuster, double deviations,
                    const std::atomic<bool>* interrupt = nullptr);

// Bundle adjustment of a stereo submap with the columns. Its result is applied to a map of one submap alone.
class ColumnsRefinement : public AdjustmentJob {
 public:
  // Null when there is nothing to adjust.
  static std::unique_ptr<ColumnsRefinement> of(const Map& map, KeyFrameId key_frame);

  AdjustmentKind kind() const override { return AdjustmentKind::camera; }
  bool run(const std::atomic<bool>& interrupt) override;
  std::optional<KeyFrameMoves> apply(SharedMap& map) const override;

 private:
  ColumnsRefinement(MapProblem submap, bool rows_are_off) : submap_(std::move(submap)), rows_are_off_(rows_are_off) {}

  MapProblem submap_;
  const bool rows_are_off_;  // those of the right image
};

}  // namespace covis
