// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/torn_image.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "covis/core/reserve.h"
#include "covis/geometry/measurement.h"
#include "covis/matching/descriptor_match.h"

namespace covis {
namespace {

constexpr size_t kMostLookedFor = 300;
constexpr int kLeastSampled = 8;       // things that only look alike are rarely displaced by one and the same way
constexpr int kFewSampled = 4;         // in the frames after a torn one
constexpr int kMostSightings = 3;      // times as many points are seen elsewhere: tiles show them all over the image
constexpr double kMostInliers = 0.15;  // share of the displaced points
constexpr float kLeastWay = 1 / 16.f, kSameWay = 1 / 40.f;  // share of the image's width

// Keeps `most` of them at most, spread over all; returns of how many one was kept.
size_t thin(std::vector<uint32_t>& values, size_t most) {
  const size_t every = std::max<size_t>(1, (values.size() + most - 1) / most);
  size_t kept = 0;
  for (size_t k = 0; k < values.size(); k += every) values[kept++] = values[k];
  values.resize(kept);
  return every;
}

}  // namespace

TornImage::TornImage() {
  constexpr size_t kFeatures = 1 << 12, kLocalPoints = 1 << 14;
  missing_.reserve(kLocalPoints);
  free_.reserve(kFeatures);
  others_.reserve(kFeatures);
  nearest_point_.reserve(kFeatures);
  matches_.reserve(kMostLookedFor);
  sightings_.reserve(kMostLookedFor);
  rows_.reserve(kMostLookedFor);
  most_rows_.reserve(kMostLookedFor);
}

bool DisplacedRows::shows_tear() const {
  return sampled >= kLeastSampled && kMostSightings * sampled >= sightings && inliers <= kMostInliers * displaced;
}

bool DisplacedRows::may_show_tear() const { return sampled >= kFewSampled && inliers <= 2 * kMostInliers * displaced; }

bool TornImage::judge(const LocalMap& local_map, std::span<const uint8_t> expected, const TrackedFrame& frame,
                      const Pinhole& camera) {
  const bool torn_just_now = torn_lately(frame.stamp, kGap);
  const DisplacedRows found = look(local_map, expected, frame, camera);
  if (found.shows_tear() || (torn_just_now && found.may_show_tear())) {
    torn_at_ = frame.stamp;
    if (!torn_since_) torn_since_ = frame.stamp;
  }
  return is_believed(frame.stamp) && torn_lately(frame.stamp, kGap);
}

DisplacedRows TornImage::look(const LocalMap& local_map, std::span<const uint8_t> expected, const TrackedFrame& frame,
                              const Pinhole& camera) {
  matched_.mark(frame);
  missing_.clear();
  reserve_ahead(missing_, expected.size());
  for (uint32_t k = 0; k < expected.size(); ++k) {
    if (expected[k] && !matched_.contains(local_map.points.id[k])) missing_.push_back(k);
  }
  const size_t every = thin(missing_, kMostLookedFor);
  if (missing_.size() < kFewSampled) return {};
  find_sightings(local_map, frame, camera);

  // Rows of the largest group of points that are displaced alike and along the rows, as what a cable or a buffer loses
  // displaces them.
  const Features& f = *frame.features;
  const float same = kSameWay * (f.grid.bounds.max_x - f.grid.bounds.min_x);
  std::vector<float>& rows = most_rows_;
  rows.clear();
  for (const Sighting& middle : sightings_) {
    if (std::abs(middle.way.y()) > same) continue;
    rows_.clear();
    for (const Sighting& s : sightings_) {
      if ((s.way - middle.way).norm() < same) rows_.push_back(s.row);
    }
    if (rows_.size() > rows.size()) std::swap(rows, rows_);
  }
  DisplacedRows found{static_cast<int>(rows.size()), static_cast<int>(rows.size() * every),
                      static_cast<int>(sightings_.size()), 0};
  if (found.sampled < kFewSampled) return found;
  std::sort(rows.begin(), rows.end());
  const float first = rows[rows.size() / 10], last = rows[rows.size() - 1 - rows.size() / 10];
  for (size_t i = 0; i < frame.source.size(); ++i) {
    found.inliers += frame.on_map(i) && f.y[i] >= first && f.y[i] <= last;
  }
  return found;
}

// Matches the missing points with the features that have none, wherever these are.
void TornImage::find_sightings(const LocalMap& local_map, const TrackedFrame& frame, const Pinhole& camera) {
  const Features& f = *frame.features;
  reserve_ahead(free_, frame.source.size());
  free_.resize(frame.source.size());
  for (size_t i = 0; i < free_.size(); ++i) free_[i] = !frame.on_map(i);
  others_.assign(f, free_);
  nearest_point_.assign(others_.padded_size(), kFarthest);
  matches_.clear();
  for (const uint32_t k : missing_) {
    const NearestTwo nearest = nearest_row(local_map.points.descriptor[k], k, others_, nearest_point_.data());
    const int best = near_distance(nearest.best), second = near_distance(nearest.second);
    if (best <= kForRansac.max_distance && static_cast<float>(best) < kForRansac.ratio * static_cast<float>(second))
      matches_.push_back({k, near_index(nearest.best)});
  }
  const float least = kLeastWay * (f.grid.bounds.max_x - f.grid.bounds.min_x);
  sightings_.clear();
  for (const Match& m : matches_) {
    if (near_index(nearest_point_[m.position]) != m.point) continue;
    const PredictedMeasurement h = predict_measurement(frame.T_cw * local_map.points.position(m.point), camera);
    const auto i = static_cast<size_t>(others_.feature(m.position));
    const Eigen::Vector2f way(f.x[i] - static_cast<float>(h.u), f.y[i] - static_cast<float>(h.v));
    if (way.norm() > least) sightings_.push_back({way, f.y[i]});
  }
}

}  // namespace covis
