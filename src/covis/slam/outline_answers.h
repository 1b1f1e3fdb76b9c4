// SPDX-License-Identifier: Apache-2.0
// The answers of DepthOutlines in a row: one alone may be that of a few things without edges. Right and wrong depth by
// these figures: docs/notes/043-torn-images.md.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "covis/features/depth_outlines.h"

namespace covis {

class OutlineAnswers {
 public:
  void add(const OutlineFit& fit);

  // True while two in a row fit better elsewhere: twice as well, or by a quarter at the same place, where no answer of
  // right depth stays.
  bool are_displaced() const { return displaced_; }
  // True from two or three in a row that fit badly on, until one fits or three tell little.
  bool fit_nowhere() const { return nowhere_; }
  // The mean of OutlineFit::here of the last answers that tell much.
  double fit() const;

 private:
  void judge_place(const OutlineFit& fit);
  void judge_fit(const OutlineFit& fit);

  std::optional<OutlineFit> last_;
  std::array<double, 3> fits_{};  // of the last answers that tell much, the newest first
  size_t fit_count_ = 0;
  int silent_ = 0;  // answers in a row that tell little
  bool displaced_ = false, nowhere_ = false;
};

}  // namespace covis
