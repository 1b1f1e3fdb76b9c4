// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/lens_answers.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace covis {
namespace {

// Standard deviations of the parameters over lenses; those of the principal point over the image's longer side.
constexpr std::array<Lens, kLensModels> kUsual{
    {{}, {.k1 = 0.3}, {.k1 = 0.3, .k2 = 0.1}, {.k1 = 0.3, .k2 = 0.1, .cx = 0.02, .cy = 0.02}}};
constexpr std::array<double Lens::*, 4> kMore{&Lens::k1, &Lens::k2, &Lens::cx, &Lens::cy};  // beside the focal length
constexpr double kFarthestCentre =
    0.06;  // greatest distance of the principal point from the middle, over the longer side
constexpr double kGreatestCoefficient = 1;
constexpr double kShown = 3;  // standard deviations of a result from which on a parameter is there

// Logarithms of the focal length.
constexpr double kNearby = 0.15;    // answers so far away are laid on one line
constexpr double kFarthest = 0.25;  // greatest step
constexpr double kNoise = 0.01;     // how much two answers differ that should be equal
constexpr double kLeastFall = 0.3;  // share of an error that a map must take away, or it repeats what it was given

using Answers = std::vector<const LensAnswer*>;

Lens usual(size_t model, double longer_side) {
  Lens usual = kUsual[model];
  usual.cx *= longer_side;
  usual.cy *= longer_side;
  return usual;
}

bool plausible(const Lens& lens, double longer_side) {
  const double focal = lens.focal / longer_side;
  return focal >= kLeastFocal && focal <= kGreatestFocal &&
         std::max(std::abs(lens.k1), std::abs(lens.k2)) <= kGreatestCoefficient &&
         std::max(std::abs(lens.cx), std::abs(lens.cy)) <= kFarthestCentre * longer_side;
}

// Returns true where what the model has beyond the one before differs from 0.
bool shows(size_t model, const Lens& lens, const Lens& sigma) {
  return std::ranges::any_of(kMore, [&](double Lens::*more) {
    return kUsual[model - 1].*more == 0 && std::abs(lens.*more) > kShown * (sigma.*more);
  });
}

bool all_have(const Answers& answers, size_t model) {
  return std::ranges::all_of(answers, [&](const LensAnswer* answer) { return answer->found[model].ok; });
}

// By weighted least squares through the changes over what was given: the line crosses zero at the result. The less
// steeply it falls, the less is known.
SettledLens on_the_line(const Answers& answers, const Lens& lens, size_t model, std::optional<double> known_fall) {
  const auto mean = [&](const auto& quantity) {
    double sum = 0, weights = 0;
    for (const LensAnswer* answer : answers) {
      const LensAdjustment& found = answer->found[model];
      const double weight = 1 / (std::pow(found.deviation().focal, 2) + kNoise * kNoise);
      sum += weight * quantity(std::log(answer->given / lens.focal), found);
      weights += weight;
    }
    return sum / weights;
  };
  // Both from the lens that it is looked for around.
  const auto change_of = [&](double at, const LensAdjustment& a) { return std::log(a.lens.focal / lens.focal) - at; };
  const double given = mean([](double at, const LensAdjustment&) { return at; });
  const double change = mean(change_of);
  const double product = mean([&](double at, const auto& a) { return (at - given) * (change_of(at, a) - change); });
  const double spread = mean([&](double at, const auto&) { return std::pow(at - given, 2); });
  const double measured_fall = known_fall ? *known_fall : -product / std::max(spread, 1e-9);
  const double fall = std::clamp(measured_fall, kLeastFall, 1.0);
  const double step = given + change / fall;
  const double misfit =
      mean([&](double at, const auto& a) { return std::pow(change_of(at, a) - change + fall * (at - given), 2); });
  const double freedom = std::max(static_cast<double>(answers.size()) - 2, 1.0);
  SettledLens settled;
  settled.change = std::abs(step);
  settled.fall = fall;
  settled.repeats = measured_fall < kLeastFall;
  settled.lens.focal = lens.focal * std::exp(std::clamp(step, -kFarthest, kFarthest));
  // The results' own deviations have one cause, the recording; what they miss the line by is each one's own.
  const auto variance = [&](double Lens::*which) {
    return mean([&](double, const LensAdjustment& a) { return std::pow(a.deviation().*which, 2); });
  };
  settled.sigma.focal = std::sqrt(variance(&Lens::focal) + misfit / freedom) / fall;
  for (double Lens::*more : kMore) {
    const double middle = mean([&](double, const LensAdjustment& a) { return a.lens.*more; });
    const double apart = mean([&](double, const LensAdjustment& a) { return std::pow(a.lens.*more - middle, 2); });
    settled.lens.*more = middle;
    settled.sigma.*more = std::sqrt(variance(more) + apart);
  }
  return settled;
}

}  // namespace

LensAnswer answer_of(BundleProblem& problem, const Lens& given, double longer_side, const std::atomic<int>* interrupt) {
  LensAnswer answer{.given = given.focal, .found = {}, .key_frames = problem.poses.size()};
  Lens begin = given;
  for (size_t model = kLensModels; model-- > 0;) {
    const LensOptions options{.usual = usual(model, longer_side),
                              .interrupted = [&] { return interrupt && *interrupt; }};
    for (double Lens::*more : kMore)
      if (options.usual.*more == 0) begin.*more = 0;
    BundleProblem attempt = problem;
    LensAdjustment& found = answer.found[model];
    found = adjust_lens(attempt, begin, options);
    for (double Lens::*more : kMore)
      if (options.usual.*more == 0) found.lens.*more = 0;
    found.ok = found.ok && plausible(found.lens, longer_side);
    if (!found.ok) continue;
    begin = found.lens;
    problem = std::move(attempt);
  }
  return answer;
}

void scale_deviations(LensAnswer& answer, double factor) {
  for (LensAdjustment& found : answer.found) {
    for (Lens* deviations : {&found.sigma, &found.scatter})
      for (double Lens::*one : {&Lens::focal, &Lens::k1, &Lens::k2, &Lens::cx, &Lens::cy}) deviations->*one *= factor;
  }
}

const LensAdjustment* believed(const LensAnswer& answer) {
  const LensAdjustment* best = nullptr;
  for (size_t model = kLensModels; model-- > 0;) {
    const LensAdjustment& found = answer.found[model];
    if (found.ok) best = &found;
    if (found.ok && model > 0 && shows(model, found.lens, found.deviation())) break;
  }
  return best;
}

std::optional<SettledLens> settle(std::span<const LensAnswer> answers, const Lens& lens, double longer_side,
                                  std::optional<double> fall) {
  Answers nearby;
  for (const LensAnswer& answer : answers)
    if (std::abs(std::log(answer.given / lens.focal)) <= kNearby) nearby.push_back(&answer);
  std::optional<SettledLens> best;
  std::vector<double> focal;                            // by each model from the richest one on
  Lens left_out = usual(kLensModels - 1, longer_side);  // deviations: the usual ones, or what a richer model says
  for (size_t model = kLensModels; model-- > 0;) {
    if (nearby.empty() || !all_have(nearby, model)) continue;
    if (best) left_out = best->sigma;
    best = on_the_line(nearby, lens, model, fall);
    focal.push_back(best->lens.focal);
    const bool shown = model > 0 && shows(model, best->lens, best->sigma);
    for (double Lens::*more : kMore)
      if (kUsual[model].*more == 0) best->sigma.*more = left_out.*more;
    if (shown) break;
  }
  if (!best) return best;
  // The richer models are not excluded: as if each were as likely as the one that is believed.
  double apart = 0;
  for (const double other : focal) apart += std::pow(std::log(other / best->lens.focal), 2);
  best->sigma.focal = std::sqrt(best->sigma.focal * best->sigma.focal + apart / static_cast<double>(focal.size()));
  return best;
}

}  // namespace covis
