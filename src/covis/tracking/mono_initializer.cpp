// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/mono_initializer.h"

#include <algorithm>
#include <utility>

#include "covis/core/random.h"
#include "covis/features/straightening.h"
#include "covis/geometry/two_view.h"
#include "covis/matching/descriptor_match.h"

namespace covis {
namespace {

constexpr float kRatio = 0.9f;  // best against second-best descriptor distance at one level

NoPoseReason reason_of(TwoViewStatus status) {
  switch (status) {
    case TwoViewStatus::ok:
      return NoPoseReason::none;
    case TwoViewStatus::too_few_matches:
      return NoPoseReason::few_matches_for_two_views;
    case TwoViewStatus::no_model:
      return NoPoseReason::no_motion_explains_matches;
    case TwoViewStatus::no_clear_winner:
      return NoPoseReason::motion_ambiguous;
    case TwoViewStatus::too_few_points:
      return NoPoseReason::few_points_of_two_views;
    case TwoViewStatus::low_parallax:
      return NoPoseReason::low_parallax;
  }
  return NoPoseReason::none;
}

}  // namespace

void MonoInitializer::reset() {
  reference_ = {};
  reason_ = NoPoseReason::waiting_for_first_view;
}

void MonoInitializer::take_reference(const FeaturesPtr& features, int64_t frame, Timestamp stamp) {
  reference_ = {frame, stamp, features};
  last_x_.assign(features->x.begin(), features->x.end());
  last_y_.assign(features->y.begin(), features->y.end());
  views_.restart(stamp);
}

std::optional<InitialMapRequest> MonoInitializer::offer(const Pinhole& camera, const FeaturesPtr& features,
                                                        int64_t frame, Timestamp stamp) {
  const StartOptions& o = options_;
  matches_ = 0;
  if (reference_.features && !straight_for(*reference_.features, camera)) reset();  // the camera was refined meanwhile
  if (!reference_.features) {
    if (features->size() <= o.init_min_matches) {
      reason_ = NoPoseReason::few_features;
    } else {
      take_reference(features, frame, stamp);
      reason_ = NoPoseReason::waiting_for_parallax;
    }
    return std::nullopt;
  }
  matches_ = match_reference(*features);
  if (matches_ < o.init_min_matches) {
    reset();
    if (features->size() > o.init_min_matches) take_reference(features, frame, stamp);
    reason_ = NoPoseReason::few_matches_with_first_view;
    return std::nullopt;
  }

  TwoViewMatches pairs;
  std::vector<uint32_t> first_feature, second_feature;
  const Features& first = *reference_.features;
  for (size_t q = 0; q < match_.size(); ++q) {
    if (match_[q] < 0) continue;
    const auto a = static_cast<uint32_t>(query_feature_[q]), b = static_cast<uint32_t>(match_[q]);
    pairs.a.emplace_back(first.x[a], first.y[a]);
    pairs.b.emplace_back(features->x[b], features->y[b]);
    const auto& sigma2 = first.pyramid->sigma2;
    pairs.sigma2.push_back(std::max(sigma2[first.level[a]], sigma2[features->level[b]]));
    first_feature.push_back(a);
    second_feature.push_back(b);
  }
  TwoViewOptions options;
  options.min_parallax_deg = o.init_min_parallax;
  options.min_points = o.init_min_points;
  options.seed = hash_seed(static_cast<uint64_t>(seed_), RandomStage::mono_initializer, static_cast<uint64_t>(frame));
  const TwoViewResult result = reconstruct_two_views(pairs, camera, options);
  const TwoViewMotion* motion = result.motions.empty() ? nullptr : &result.motions.front();
  if (result.motions.size() > 1) motion = views_.choose(result.motions, first_feature, camera, stamp);
  const TwoViewStatus status = motion ? motion->status(options) : result.status;
  if (status != TwoViewStatus::ok) {
    reason_ = reason_of(status);
    if (views_.is_next_due()) remember(pairs, first_feature, stamp);
    return std::nullopt;
  }
  InitialMapRequest request;
  request.first = reference_;
  request.second = {frame, stamp, features};
  request.T_21 = motion->T_21;
  for (size_t k = 0; k < first_feature.size(); ++k) {
    if (motion->triangulated[k]) request.points.push_back({motion->points_1[k], first_feature[k], second_feature[k]});
  }
  return request;
}

void MonoInitializer::remember(const TwoViewMatches& pairs, const std::vector<uint32_t>& first_feature,
                               Timestamp stamp) {
  std::vector<ViewsBetween::Sighting> seen;
  seen.reserve(first_feature.size());
  for (size_t k = 0; k < first_feature.size(); ++k) {
    const Eigen::Vector2f place = pairs.b[k].cast<float>();
    seen.push_back({first_feature[k], place.x(), place.y(), static_cast<float>(1 / pairs.sigma2[k])});
  }
  views_.add(stamp, std::move(seen));
}

// Finds the reference view's finer keypoints in this frame, each in a window around its last place.
int MonoInitializer::match_reference(const Features& features) {
  const Features& first = *reference_.features;
  queries_.clear();
  query_feature_.clear();
  for (int i = 0; i < first.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    const int level = first.level[k];
    if (level > options_.init_levels) continue;
    queries_.push_back({last_x_[k], last_y_[k], 0.0f, static_cast<float>(options_.init_window), level - 1, level + 1,
                        &first.descriptor[k]});
    query_feature_.push_back(i);
  }
  matcher_.match(features, queries_, {}, {}, {.max_distance = kHammingLow, .ratio = kRatio}, match_);
  std::vector<float> angle_a, angle_b;
  std::vector<size_t> query;
  for (size_t q = 0; q < match_.size(); ++q) {
    if (match_[q] < 0) continue;
    angle_a.push_back(first.angle[static_cast<size_t>(query_feature_[q])]);
    angle_b.push_back(features.angle[static_cast<size_t>(match_[q])]);
    query.push_back(q);
  }
  std::vector<uint8_t> keep(query.size(), 1);
  const int kept = check_rotation(angle_a, angle_b, keep);
  for (size_t k = 0; k < query.size(); ++k) {
    if (!keep[k]) {
      match_[query[k]] = -1;
      continue;
    }
    const auto a = static_cast<size_t>(query_feature_[query[k]]), b = static_cast<size_t>(match_[query[k]]);
    last_x_[a] = features.x[b];
    last_y_[a] = features.y[b];
  }
  return kept;
}

}  // namespace covis
