// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/registration_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace covis {
namespace {

constexpr size_t kLeastSights = 600, kMostSights = 4000;
constexpr double kMeasured = 0.7;  // sights with a depth, as a share of those that have one by the present registration

float median_of(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double usual_inverse_z(const std::vector<DepthSight>& sights) {
  std::vector<float> z;
  for (const DepthSight& sight : sights) z.push_back(sight.z);
  return 1 / static_cast<double>(median_of(z));
}

// Every so many of them, for not more than `most`.
std::vector<DepthSight> some_of(const std::vector<DepthSight>& sights, size_t most) {
  std::vector<DepthSight> some;
  const size_t step = (sights.size() + most - 1) / most;
  for (size_t k = 0; k < sights.size(); k += step) some.push_back(sights[k]);
  return some;
}

// Steps from the present registration: of its scale, its shift at the usual depth, and its parallax, of which none
// does what another one does.
using Steps = std::array<double, 5>;
constexpr size_t kWithoutParallax = 3, kWithParallax = 5;

class Registrations {
 public:
  Registrations(const std::vector<DepthSight>& sights, const DepthRegistration& present)
      : pixels_(sights.front().depth->width() / 80.0), usual_(usual_inverse_z(sights)), present_(present) {}

  // A step is a fiftieth of the scale; an eightieth of the image's width; and a parallax that moves by as much what is
  // half as far away as usual.
  DepthRegistration at(const Steps& s) const {
    DepthRegistration r = present_;
    r.scale += s[0] / 50;
    r.parallax_x += s[3] * pixels_ / usual_;
    r.parallax_y += s[4] * pixels_ / usual_;
    r.shift_x += (s[1] - s[3]) * pixels_;
    r.shift_y += (s[2] - s[4]) * pixels_;
    return r;
  }

 private:
  const double pixels_, usual_;
  const DepthRegistration present_;
};

// Goes from better to better registrations.
class Search {
 public:
  Search(const std::vector<DepthSight>& sights, const Registrations& registrations, const Eigen::Vector2d& centre)
      : sights_(sights), registrations_(registrations), centre_(centre), best_(fit({})) {
    least_ = static_cast<int>(kMeasured * best_.measured);
  }

  const Steps& steps() const { return steps_; }
  DepthRegistration found() const { return registrations_.at(steps_); }

  // Tries scales from 0.84 to 1.16, and shifts by up to a twenty-seventh of the width.
  void look_around() {
    constexpr double kScales = 8, kShifts = 3;
    for (double scale = -kScales; scale <= kScales; ++scale)
      for (double x = -kShifts; x <= kShifts; ++x)
        for (double y = -kShifts; y <= kShifts; ++y) improves({scale, x, y, 0, 0});
  }
  // Downhill from there, with the first parameters alone.
  void descend(const Steps& from, size_t parameters) {
    constexpr int kHalvings = 7, kRounds = 3;
    improves(from);
    double step = 1;
    for (int halving = 0; halving < kHalvings; ++halving, step /= 2) {
      for (int round = 0; round < kRounds; ++round) {
        bool better = false;
        for (size_t k = 0; k < parameters; ++k)
          for (const double by : {-step, step}) better |= improves(stepped(k, by));
        if (!better) break;
      }
    }
  }

 private:
  RegistrationFit fit(const Steps& steps) const { return fit_of(sights_, registrations_.at(steps), centre_); }
  Steps stepped(size_t parameter, double by) const {
    Steps steps = steps_;
    steps[parameter] += by;
    return steps;
  }
  bool improves(const Steps& steps) {
    const RegistrationFit there = fit(steps);
    if (there.measured < least_ || !(there.error < best_.error)) return false;
    best_ = there;
    steps_ = steps;
    return true;
  }

  const std::vector<DepthSight>& sights_;
  const Registrations& registrations_;
  const Eigen::Vector2d centre_;
  Steps steps_{};
  RegistrationFit best_;
  int least_ = 0;
};

// The root of the mean square by which two registrations differ at the sights, pixels.
double difference(const std::vector<DepthSight>& sights, const DepthRegistration& a, const DepthRegistration& b,
                  const Eigen::Vector2d& centre) {
  double sum = 0;
  for (const DepthSight& s : sights) {
    const Eigen::Vector2d pixel = s.pixel.cast<double>();
    const double inverse_z = 1 / static_cast<double>(s.z);
    sum += (a.pixel(pixel, centre, inverse_z) - b.pixel(pixel, centre, inverse_z)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(sights.size()));
}

// Asks the sights for another registration.
class Question {
 public:
  Question(const std::vector<DepthSight>& sights, const DepthRegistration& present, const Eigen::Vector2d& centre)
      : sights_(sights), present_(present), centre_(centre), registrations_(sights, present) {
    for (const DepthSight& sight : sights_) half_[static_cast<size_t>(sight.view % 2)].push_back(sight);
    for (size_t half = 0; half < 2; ++half)
      if (!half_[half].empty()) begin_[half] = look_around(half_[half]);
  }

  // The greater error of one half by what the other half found, as a share of the present one's; 1 where they find
  // different ones.
  double share(size_t parameters) const {
    constexpr double kAlike = 0.5;  // differences of halves, as a share of what they differ by from the present one
    std::array<DepthRegistration, 2> found;
    double greatest = 0;
    for (size_t half = 0; half < 2; ++half) {
      const std::vector<DepthSight>& others = half_[1 - half];
      if (half_[half].empty() || others.empty()) return 1;
      found[half] = descend(half_[half], begin_[half], parameters);
      const RegistrationFit before = fit_of(others, present_, centre_), after = fit_of(others, found[half], centre_);
      if (!(before.error > 0) || after.measured < kMeasured * before.measured) return 1;
      greatest = std::max(greatest, after.error / before.error);
    }
    const double apart = difference(sights_, found[0], found[1], centre_);
    return apart <= kAlike * difference(sights_, found[0], present_, centre_) ? greatest : 1;
  }
  DepthRegistration best(size_t parameters) const { return descend(sights_, begin_[0], parameters); }

 private:
  Steps look_around(const std::vector<DepthSight>& sights) const {
    constexpr size_t kSome = 1000;
    const std::vector<DepthSight> some = some_of(sights, kSome);
    Search search(some, registrations_, centre_);
    search.look_around();
    return search.steps();
  }
  DepthRegistration descend(const std::vector<DepthSight>& sights, const Steps& begin, size_t parameters) const {
    Search search(sights, registrations_, centre_);
    search.descend(begin, parameters);
    return search.found();
  }

  const std::vector<DepthSight>& sights_;
  const DepthRegistration present_;
  const Eigen::Vector2d centre_;
  const Registrations registrations_;
  std::array<std::vector<DepthSight>, 2> half_;  // those of even and of odd views
  std::array<Steps, 2> begin_{};                 // the best of a first look of each half
};

}  // namespace

RegistrationFit fit_of(const std::vector<DepthSight>& sights, const DepthRegistration& registration,
                       const Eigen::Vector2d& centre) {
  constexpr float kMostOff = 0.1f;
  const bool moved = registration.any();
  std::vector<float> ratios;
  ratios.reserve(sights.size());
  for (const DepthSight& s : sights) {
    const float inverse = s.depth->inverse_near(
        moved ? registration.pixel(s.pixel.cast<double>(), centre, 1 / static_cast<double>(s.z)).cast<float>()
              : s.image);
    if (inverse > 0) ratios.push_back(inverse * s.z);
  }
  if (ratios.empty()) return {};
  const float median = median_of(ratios);
  double sum = 0;
  for (const float ratio : ratios) sum += static_cast<double>(std::min(std::abs(ratio / median - 1), kMostOff));
  return {sum / static_cast<double>(ratios.size()), static_cast<int>(ratios.size())};
}

std::optional<DepthRegistration> find_registration(const std::vector<DepthSight>& all, const DepthRegistration& present,
                                                   const Eigen::Vector2d& centre, double share) {
  constexpr double kWorthParallax = 0.97;
  if (all.size() < kLeastSights) return std::nullopt;
  const std::vector<DepthSight> sights = some_of(all, kMostSights);
  const Question question(sights, present, centre);
  const double plain = question.share(kWithoutParallax);
  if (!(plain < share)) return std::nullopt;
  const bool parallax = question.share(kWithParallax) < kWorthParallax * plain;
  return question.best(parallax ? kWithParallax : kWithoutParallax);
}

}  // namespace covis
