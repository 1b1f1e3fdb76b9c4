// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/outline_answers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace covis {
namespace {

constexpr double kLeastFit = 5;        // standard deviations; right depth has 5.5 and more in the mean of three answers
constexpr int kSilent = 3;             // answers that tell little, after which those before count no more
constexpr double kLeastElsewhere = 8;  // standard deviations that no chance gives
constexpr double kTimesBetter = 3, kTimesBetterOfAnotherSize = 2.4, kTimesBetterAtAPlace = 1.25;

// True when both answers say that depth belongs to one other place.
bool agree(const OutlineFit& a, const OutlineFit& b) {
  if (a.elsewhere <= kLeastElsewhere || b.elsewhere <= kLeastElsewhere) return false;
  const double ratio = std::min(a.ratio(), b.ratio());
  if (ratio > kTimesBetter) return true;
  const OutlineFit::Place &p = a.place, &q = b.place;
  if (p.has_another_size() && q.has_another_size()) return ratio > kTimesBetterOfAnotherSize && p.is_about_as_large(q);
  return ratio > kTimesBetterAtAPlace && p.is_at(q);
}

}  // namespace

bool OutlineAnswers::is_next_due() {
  constexpr size_t kFirst = 50, kOften = 2, kSeldom = 4;  // frames
  const size_t frame = frames_++;
  const bool often = frame < kFirst || (last_ && (last_->here < kLeastFit || last_->is_displaced()));
  if (frame > 0 && frame - last_look_ < (often ? kOften : kSeldom)) return false;
  last_look_ = frame;
  return true;
}

void OutlineAnswers::add(const OutlineFit& fit) {
  displaced_ = last_ && agree(*last_, fit);
  judge_fit(fit);
  last_ = fit;
}

void OutlineAnswers::judge_fit(const OutlineFit& fit) {
  if (!fit.tells_much()) {
    if (++silent_ < kSilent) return;
    fit_count_ = 0;
    nowhere_ = false;
    return;
  }
  silent_ = 0;
  std::shift_right(fits_.begin(), fits_.end(), 1);
  fits_[0] = fit.here;
  fit_count_ = std::min(fits_.size(), fit_count_ + 1);
  nowhere_ = fit.here < kLeastFit && (nowhere_ || (fit_count_ == fits_.size() && this->fit() < kLeastFit));
}

double OutlineAnswers::fit() const {
  const auto end = fits_.begin() + static_cast<std::ptrdiff_t>(fit_count_);
  return fit_count_ == 0 ? 0 : std::accumulate(fits_.begin(), end, 0.0) / static_cast<double>(fit_count_);
}

}  // namespace covis
