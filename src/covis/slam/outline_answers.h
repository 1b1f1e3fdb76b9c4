// SPDX-License-Identifier: Apache-2.0
// Which frames DepthOutlines looks at, and what its answers in a row say: one alone may be that of a few things without
// edges. Right and wrong depth by these figures: docs/notes/044-depth-doubted-sooner.md.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "covis/features/depth_outlines.h"

namespace covis {

class OutlineAnswers {
 public:
  // For each frame: true for one to be looked at. At first, and after an answer that may be of wrong depth, these are
  // every second one, in doubt all, else every fourth.
  bool is_next_due();
  // An answer of a camera that stands can end a doubt, and says nothing else.
  void add(const OutlineFit& fit);

  // True while two in a row fit far better elsewhere, or three better at one other place, where no three answers of
  // right depth are.
  bool are_displaced() const { return displaced_; }
  // True from three in a row whose mean fits badly on, until one fits or three tell little.
  bool fit_nowhere() const { return nowhere_; }
  // The mean of OutlineFit::here of the last three answers that tell much, or of those that there are.
  double fit() const;

 private:
  void judge_fit(const OutlineFit& fit);

  size_t frames_ = 0, last_look_ = 0;
  std::optional<OutlineFit> last_;
  std::array<double, 3> fits_{};  // fits of the last answers that tell much, the newest first
  size_t fit_count_ = 0;
  int silent_ = 0;        // answers in a row that tell little
  int at_one_place_ = 0;  // answers in a row that fit better at one other place, with the last
  bool displaced_ = false, nowhere_ = false;
};

}  // namespace covis
