// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/depth_against_map.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "covis/core/reserve.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

constexpr int kFewestPoints = 6, kFewPoints = 30, kManyPoints = 100;
constexpr double kErrorOfFewest = 0.3;
constexpr double kErrorOfFew = 0.09, kErrorOfMany = 0.045, kSuspicious = 0.03, kAgreeing = 0.02;
constexpr double kMostSigmas = 3, kUsualSigmas = 1.5;  // right depth has 0.67
// The greatest errors where images alone made the map; that of the shape is a share of the relief.
constexpr double kLeastDrift = 0.08, kDriftPerSecond = 0.06, kMostDrift = 0.35, kShape = 1.0 / 6;

constexpr int kInARow = 3;                     // frames
constexpr double kLeast = 0.5, kBelieved = 2;  // seconds that a contradiction lasts until it is believed: least, most

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Calls visit(measured, mapped, feature) for each depth that is precise.
template <class Visit>
void for_each_depth(const TrackedFrame& frame, const Features& measured, const Pinhole& camera, Visit&& visit) {
  const Eigen::RowVector3d axis = frame.T_cw.R().row(2);
  const double t_z = frame.T_cw.t().z();
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (!frame.on_map(i) || !measured.has_depth(static_cast<int>(i))) continue;
    const double z = axis.dot(frame.positions[i]) + t_z;
    if (z > 0 && is_precise_depth(z, camera)) visit(static_cast<double>(measured.depth[i]), z, i);
  }
}

// True for a point whose reference key frame measured its depth.
bool is_of_depth(const Map& map, MapPointId id) {
  const MapPoint* point = map.find(id);
  const KeyFrame* reference = point ? map.find(point->reference) : nullptr;
  return reference && reference->features->has_depth(static_cast<int>(point->feature_in(point->reference)));
}

}  // namespace

// The fewer points, the more has to be wrong: some may be wrong matches.
bool DepthAgainstMap::contradicts() const {
  if (points < kFewestPoints || sigmas <= kMostSigmas) return false;
  return error > (points < kFewPoints ? kErrorOfFewest : points < kManyPoints ? kErrorOfFew : kErrorOfMany);
}

bool DepthAgainstMap::agrees() const {
  return points >= kFewestPoints && (error <= kAgreeing || sigmas <= kUsualSigmas);
}

bool DepthAgainstMap::differs_by_drift(double seconds) const {
  const double drift = std::min(kMostDrift, kLeastDrift + kDriftPerSecond * seconds);
  return shape && points >= kFewPoints && shape->of_depth < kFewestPoints && error <= drift &&
         shape->error < kShape * shape->relief;
}

bool DepthAgainstMap::is_suspicious() const { return points > 0 && error > kSuspicious && sigmas > kUsualSigmas; }

DepthComparer::DepthComparer() {
  constexpr size_t kFeatures = 1 << 12;
  depths_.reserve(kFeatures);
  values_.reserve(kFeatures);
}

DepthAgainstMap DepthComparer::compare(const TrackedFrame& frame, const Features& measured, const Pinhole& camera,
                                       const Map* map) {
  constexpr double kLeastNoise = 1e-3;  // share of a depth
  constexpr double kOfCamera = 5;       // times its noise: its depth is of another moment and place than its image
  depths_.clear();
  for_each_depth(frame, measured, camera, [this](double depth, double mapped, size_t feature) {
    depths_.push_back({depth, mapped, feature});
  });
  if (depths_.empty()) return {};
  DepthAgainstMap found;
  found.points = static_cast<int>(depths_.size());
  values_.clear();
  for (const Depth& d : depths_) values_.push_back(std::max(d.measured / d.mapped, d.mapped / d.measured));
  found.error = std::log(median(values_));
  if (found.error <= kAgreeing) return found;
  const double factor = camera.depth_noise.known() ? kOfCamera : 1;
  values_.clear();
  for (const Depth& d : depths_) {
    const double error = std::abs(std::log(d.measured / d.mapped));
    values_.push_back(error / std::max(kLeastNoise, factor * depth_noise_share(d.mapped, camera)));
  }
  found.sigmas = median(values_);
  if (map) found.shape = shape_in(*map, frame);
  return found;
}

DepthShape DepthComparer::shape_in(const Map& map, const TrackedFrame& frame) {
  const auto deviation = [this](auto&& value) {
    values_.clear();
    for (const Depth& d : depths_) values_.push_back(std::log(value(d)));
    const double middle = median(values_);
    for (double& v : values_) v = std::abs(v - middle);
    return median(values_);
  };
  const auto of_depth =
      std::ranges::count_if(depths_, [&](const Depth& d) { return is_of_depth(map, frame.points[d.feature]); });
  return {static_cast<int>(of_depth), deviation([](const Depth& d) { return d.measured / d.mapped; }),
          deviation([](const Depth& d) { return d.mapped; })};
}

int DepthComparer::count(const TrackedFrame& frame, const Features& measured, const Pinhole& camera) {
  int depths = 0;
  for_each_depth(frame, measured, camera, [&](double, double, size_t) { ++depths; });
  return depths;
}

FeaturesPtr DepthRemover::without_depth(const Features& features) {
  const std::shared_ptr<Features> image_alone = ring_.copy_of(features);
  std::fill(image_alone->depth.begin(), image_alone->depth.end(), -1.0f);
  std::fill(image_alone->u_right.begin(), image_alone->u_right.end(), -1.0f);
  return image_alone;
}

FeaturesPtr DepthBelief::receive(FeaturesPtr measured) {
  measured_ = std::move(measured);
  return contradicts() ? remover_.without_depth(*measured_) : measured_;
}

void DepthBelief::straighten_for(const Pinhole& camera, TrackedFrame& frame) {
  const bool as_measured = frame.features == measured_;
  frame.straighten_for(camera);
  if (as_measured) measured_ = frame.features;
}

double DepthBelief::judge(const TrackedFrame& frame, const Pinhole& camera, const SharedMap* live) {
  if (frame.features == measured_) return 0;
  const auto map = live ? std::optional(live->read()) : std::nullopt;
  judge(comparer_.compare(frame, *measured_, camera, map ? &**map : nullptr), frame.stamp);
  constexpr double kLeast = 1e-3;  // reported if no depth could be compared
  return contradicts() ? std::max(kLeast, last_.error) : 0;
}

void DepthBelief::begin(Timestamp stamp) {
  const bool contradicted_just_now = contradicts() && stamp - judged_ < from_seconds(kLeast);
  if (contradicted_just_now && drifted_ < kInARow) doubted_ = stamp;
  begun_ = stamp;
  since_.reset();
  agreeing_ = drifted_ = 0;
}

void DepthBelief::change_map(const TrackedFrame& frame) {
  if (frame.features == measured_) {
    since_.reset();  // its depth agrees there
  } else if (since_) {
    since_ = frame.stamp;
  }
  begun_.reset();
  agreeing_ = drifted_ = 0;
  doubted_.reset();
}

void DepthBelief::judge(const DepthAgainstMap& found, Timestamp stamp) {
  // Where the shape is not known, as the map could not be read, what was seen before stays.
  if (!since_ || found.agrees() || found.points == 0) {
    drifted_ = 0;
  } else if (found.shape) {
    drifted_ = found.differs_by_drift(to_seconds(stamp - *since_)) ? drifted_ + 1 : 0;
  }
  agreeing_ = found.agrees() ? agreeing_ + 1 : 0;
  if (agreeing_ >= kInARow) {
    since_.reset();
  } else if (!since_) {
    since_ = stamp;
  }
  last_ = found;
  judged_ = stamp;
}

bool DepthBelief::is_on_probation(Timestamp now) const { return doubted_ && now - *doubted_ < from_seconds(kBelieved); }

bool DepthBelief::blames_map(Timestamp now) const {
  if (!since_ || !last_.contradicts() || last_.points < kFewPoints) return false;
  if (drifted_ >= kInARow) return true;
  const Timestamp agreed = begun_ ? *since_ - *begun_ : from_seconds(kBelieved);
  return now - *since_ >= std::clamp(agreed, from_seconds(kLeast), from_seconds(kBelieved));
}

}  // namespace covis
