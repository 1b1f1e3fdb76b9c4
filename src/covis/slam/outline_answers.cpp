// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/outline_answers.h"

#include <algorithm>
#include <numeric>

namespace covis {
namespace {

constexpr double kLeastFit = 5;        // standard deviations; right depth has 5.5 and more in the mean of three answers
constexpr int kSilent = 3;             // answers that tell little, after which those before count no more
constexpr double kLeastElsewhere = 8;  // standard deviations that no chance gives
// Times better elsewhere than here: anywhere; of another size; at one place; at one place three times, and mirrored,
// for which few places are tried.
constexpr double kAnywhere = 3, kOfAnotherSize = 2.4, kAtAPlace = 2, kThreeTimes = 1.25, kThreeTimesMirrored = 1.5;

bool is_better_elsewhere(const OutlineFit& fit) {
  return fit.elsewhere > kLeastElsewhere && fit.ratio() > (fit.tells_much() ? kThreeTimes : kOfAnotherSize);
}

// True when both say that depth of its own size belongs to one other place.
bool are_at_one_place(const OutlineFit& a, const OutlineFit& b) {
  const double least = b.place.is_mirrored() ? kThreeTimesMirrored : kThreeTimes;
  return is_better_elsewhere(a) && is_better_elsewhere(b) && !b.place.has_another_size() && b.place.is_at(a.place) &&
         std::min(a.ratio(), b.ratio()) > least;
}

// True when two answers suffice to say that depth belongs elsewhere.
bool agree(const OutlineFit& a, const OutlineFit& b) {
  if (!is_better_elsewhere(a) || !is_better_elsewhere(b)) return false;
  const double ratio = std::min(a.ratio(), b.ratio());
  if (ratio > kAnywhere) return true;
  const OutlineFit::Place &p = a.place, &q = b.place;
  if (p.has_another_size() && q.has_another_size()) return ratio > kOfAnotherSize && p.is_about_as_large(q);
  return ratio > kAtAPlace && p.is_at(q);
}

}  // namespace

bool OutlineAnswers::is_next_due() {
  constexpr size_t kFirst = 50, kOften = 2, kSeldom = 4;  // frames
  const size_t frame = frames_++;
  const bool may_be_wrong = last_ && ((last_->tells_much() && last_->here < kLeastFit) ||
                                      (is_better_elsewhere(*last_) && !last_->place.has_another_size()));
  const size_t every = displaced_ || nowhere_ ? 1 : frame < kFirst || may_be_wrong ? kOften : kSeldom;
  if (frame > 0 && frame - last_look_ < every) return false;
  last_look_ = frame;
  return true;
}

void OutlineAnswers::add(const OutlineFit& fit) {
  if (!fit.new_view) {
    displaced_ = displaced_ && is_better_elsewhere(fit);
    nowhere_ = nowhere_ && fit.here < kLeastFit;
    return;
  }
  constexpr int kInARow = 3;
  at_one_place_ = last_ && are_at_one_place(*last_, fit) ? at_one_place_ + 1 : 1;
  displaced_ = last_ && (at_one_place_ >= kInARow || agree(*last_, fit));
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
