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
constexpr double kPlausible = 3;  // of those deviations, and no more, is a lens off
constexpr double kShown = 3;      // standard deviations of a result from which on a parameter is there

// Logarithms of the focal length.
constexpr double kNearby = 0.15;    // answers so far away are laid on one line
constexpr double kFarthest = 0.25;  // greatest step
constexpr double kNoise = 0.01;     // how much two answers differ that should be equal
constexpr double kLeastFall = 0.3;  // share of an error that a map must take away, or it repeats what it was given

using Answers = std::vector<const LensAnswer*>;

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
SettledLens on_the_line(const Answers& answers, const Lens& lens, size_t model) {
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
  const double measured_fall = -product / std::max(spread, 1e-9);
  const double fall = std::clamp(measured_fall, kLeastFall, 1.0);
  const double step = given + change / fall;
  const double misfit =
      mean([&](double at, const auto& a) { return std::pow(change_of(at, a) - change + fall * (at - given), 2); });
  const double freedom = std::max(static_cast<double>(answers.size()) - 2, 1.0);
  SettledLens settled;
  settled.change = std::abs(step);
  settled.repeats = measured_fall < kLeastFall;
  settled.lens.focal = lens.focal * std::exp(std::clamp(step, -kFarthest, kFarthest));
  // The results' own deviations have one cause, the recording; what they miss the line by is each one's own.
  const auto variance = [&](double Lens::*which) {
    return mean([&](double, const LensAdjustment& a) { return std::pow(a.deviation().*which, 2); });
  };
  settled.sigma.focal = std::sqrt(variance(&Lens::focal) + misfit / freedom) / fall;
  for (double Lens::*more : kMore) {
    settled.lens.*more = mean([&](double, const LensAdjustment& a) { return a.lens.*more; });
    settled.sigma.*more = std::sqrt(variance(more));
  }
  return settled;
}

}  // namespace

LensAnswer answer_of(BundleProblem& problem, const Lens& given, double longer_side, const std::atomic<int>* interrupt) {
  LensAnswer answer{.given = given.focal, .found = {}, .key_frames = problem.poses.size()};
  Lens begin = given;
  for (size_t model = kLensModels; model-- > 0;) {
    Lens usual = kUsual[model];
    usual.cx *= longer_side;
    usual.cy *= longer_side;
    for (double Lens::*more : kMore)
      if (usual.*more == 0) begin.*more = 0;
    LensAdjustment& found = answer.found[model];
    found = adjust_lens(problem, begin, {.usual = usual, .interrupt = interrupt});
    for (double Lens::*more : kMore) {
      if (usual.*more == 0) found.lens.*more = 0;
      found.ok = found.ok && std::abs(found.lens.*more) <= kPlausible * (usual.*more);
    }
    if (found.ok) begin = found.lens;
  }
  return answer;
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

std::optional<SettledLens> settle(std::span<const LensAnswer> answers, const Lens& lens) {
  Answers nearby;
  for (const LensAnswer& answer : answers)
    if (std::abs(std::log(answer.given / lens.focal)) <= kNearby) nearby.push_back(&answer);
  std::optional<SettledLens> best;
  double richest = 0;
  for (size_t model = kLensModels; model-- > 0;) {
    if (nearby.empty() || !all_have(nearby, model)) continue;
    SettledLens simpler = on_the_line(nearby, lens, model);
    if (best) {
      for (double Lens::*more : kMore) simpler.sigma.*more = std::max(simpler.sigma.*more, best->sigma.*more);
    } else {
      richest = simpler.lens.focal;
    }
    best = simpler;
    if (model > 0 && shows(model, best->lens, best->sigma)) break;
  }
  // What was left out is not excluded.
  if (best) best->sigma.focal = std::hypot(best->sigma.focal, std::log(best->lens.focal / richest));
  return best;
}

}  // namespace covis
