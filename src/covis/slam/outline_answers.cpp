// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/outline_answers.h"

#include <algorithm>
#include <numeric>

namespace covis {
namespace {

constexpr double kMostOfTwo = 4, kMostOfThree = 5.5, kLeastFit = 5;  // standard deviations
constexpr int kSilent = 3;

}  // namespace

void OutlineAnswers::add(const OutlineFit& fit) {
  judge_place(fit);
  judge_fit(fit);
  last_ = fit;
}

void OutlineAnswers::judge_place(const OutlineFit& fit) {
  displaced_ = last_ && ((last_->is_displaced() && fit.is_displaced()) ||
                         (last_->is_better_elsewhere() && fit.is_better_elsewhere() && fit.place.is_at(last_->place)));
}

void OutlineAnswers::judge_fit(const OutlineFit& fit) {
  if (!fit.tells_much()) {
    fit_count_ = 0;
    if (++silent_ >= kSilent) nowhere_ = false;
    return;
  }
  silent_ = 0;
  std::shift_right(fits_.begin(), fits_.end(), 1);
  fits_[0] = fit.here;
  fit_count_ = std::min(fits_.size(), fit_count_ + 1);
  if (fit.here >= kLeastFit) {
    nowhere_ = false;
  } else {
    nowhere_ |= (fit_count_ >= 2 && fits_[0] + fits_[1] < 2 * kMostOfTwo) ||
                (fit_count_ == fits_.size() && this->fit() < kMostOfThree);
  }
}

double OutlineAnswers::fit() const {
  const auto end = fits_.begin() + static_cast<std::ptrdiff_t>(fit_count_);
  return fit_count_ == 0 ? 0 : std::accumulate(fits_.begin(), end, 0.0) / static_cast<double>(fit_count_);
}

}  // namespace covis
